"""A room's corner before a Kinect v1: a frame at each of five distances, three planes fitted to its depth."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.lens.boards.pictures import read_picture
from fusion.geometry.camera import Camera, Principle
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.mesh import Mesh
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording
from tools.reproduce.real_scenes.scene import write_scene

# of the recording's own program
CAMERA = Camera(
    640,
    480,
    522.96,
    523.88,
    329.09,
    254.71,
    depth_scale=1000.0,
    principle=Principle.STRUCTURED_LIGHT,
    sensor="Kinect v1",
)
NEAR = 0.012  # [1] of the depth: what belongs to a plane, steps of the rounding included
OFF_M = 0.04  # [m] from every plane: something else that stands there
PLACE = (0.01, 0.005)  # [m], [rad] the planes were fitted to the frame itself
FLAT_M = 0.003  # [m] guess
HALF_M = 3.0  # [m] a plane goes on beyond the image; where planes meet, the nearer one is seen
LEAST = 0.05  # share of the image that a wall covers


def write_corners(source: Path, folder: Path) -> list[Path]:
    """One recording per distance; their folders."""
    written = []
    for path in sorted((source / "640x480").glob("*_d.png")):
        depth = read_picture(path).astype(np.float32) / 1000
        depth[depth == 0] = np.nan
        planes = _planes(depth)
        rays = np.dstack([CAMERA.rays(), np.ones(CAMERA.shape)])
        with np.errstate(all="ignore"):
            seen = np.stack([1 / (rays @ law) for law in planes])
            off = np.abs(depth - np.min(np.where(seen > 0, seen, np.inf), axis=0))
        out = folder / path.name.removesuffix("_d.png")
        frames = iter([Frame(0, 0.0, np.where(off < OFF_M, depth, np.float32(np.nan)))])
        write_recording(out, CAMERA, frames, Trajectory(np.zeros(1), np.eye(4)[None]))
        write_scene(out, _mesh(planes), ("nominal", *PLACE), FLAT_M)
        written.append(out)
    return written


def _planes(depth: NDArray[np.floating]) -> list[NDArray[np.float64]]:
    """Laws 1 / z = a . ray (3,) of the largest planes, one after the other."""
    rng = np.random.default_rng(0)
    rays = np.dstack([CAMERA.rays(), np.ones(CAMERA.shape)])[np.isfinite(depth)][::20]
    z = depth[np.isfinite(depth)][::20]
    whole = len(z)
    found: list[NDArray[np.float64]] = []
    while len(found) < 3:
        best = np.zeros(len(z), bool)
        for _ in range(400):
            some = rng.choice(len(z), 3, replace=False)
            try:
                law = np.linalg.solve(rays[some], 1 / z[some])
            except np.linalg.LinAlgError:
                continue
            inside = np.abs(z * (rays @ law) - 1) < NEAR
            best = inside if inside.sum() > best.sum() else best
        if best.sum() < LEAST * whole:
            break
        found.append(np.linalg.lstsq(rays[best], 1 / z[best], rcond=None)[0])
        rays, z = rays[~best], z[~best]
    return found


def _mesh(planes: list[NDArray[np.float64]]) -> Mesh:
    vertices, faces = [], []
    for k, law in enumerate(planes):
        normal = law / np.linalg.norm(law)
        foot = law / (law @ law)
        x = np.cross([0.0, 1.0, 0.0] if abs(normal[1]) < 0.9 else [1.0, 0.0, 0.0], normal)
        x *= HALF_M / np.linalg.norm(x)
        y = np.cross(normal, x)
        vertices += [foot - x - y, foot + x - y, foot + x + y, foot - x + y]
        faces += [[4 * k, 4 * k + 2, 4 * k + 1], [4 * k, 4 * k + 3, 4 * k + 2]]
    return Mesh(np.array(vertices), np.array(faces, np.int32))
