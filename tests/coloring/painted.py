"""A painted box in a green room: pictures from known places, and a mesh of it that is a little off."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fusion.geometry.camera import Camera
from fusion.geometry.pose import exp
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.comparison.surface_samples import vertex_normals
from fusion.mesh.mesh import Mesh
from fusion.mesh.vertices import joined as welded
from fusion.recording.recording import Frame, Recording
from fusion.simulation.rendering.render import RayCaster
from fusion.simulation.scene.shapes import box, joined

CAMERA = Camera(320, 240, 300.0, 301.0, 160.3, 119.1, distortion=(0.04, -0.08))
HALF = 0.1  # of the box's edge [m]
GREEN = (0, 255, 0)


def paint(points):
    """(n, 3) no green, and nowhere steeper than 2.6 counts a millimetre."""
    waves = np.sin(points * 2 * np.pi / 0.15 + np.array([0.0, 1.0, 2.0]))
    red, blue = 140 + 60 * waves[:, 0] * waves[:, 1], 140 + 60 * waves[:, 2]
    return np.rint(np.column_stack([red, np.full(len(points), 20), blue])).astype(np.uint8)


def cube(half=HALF, cells=50, painted=paint) -> Mesh:
    """A box about the origin with fine faces, painted by position, with normals."""
    grid = np.linspace(-half, half, cells + 1)
    a, b = (g.ravel() for g in np.meshgrid(grid, grid, indexing="ij"))
    i = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    quads = np.concatenate(
        [np.column_stack([i, i + cells + 1, i + cells + 2]), np.column_stack([i, i + cells + 2, i + 1])]
    )
    vertices, faces = [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            sheet = np.empty((len(a), 3))
            sheet[:, axis], sheet[:, (axis + 1) % 3], sheet[:, (axis + 2) % 3] = side * half, a, b
            faces.append((quads if side > 0 else quads[:, ::-1]) + len(vertices) * len(a))
            vertices.append(sheet)
    whole = welded(Mesh(np.concatenate(vertices), np.concatenate(faces).astype(np.int32)))
    normals = vertex_normals(whole).astype(np.float32)
    return Mesh(whole.vertices, whole.faces, normals, painted(whole.vertices))


def off(mesh: Mesh, by: float) -> Mesh:
    """The mesh as a scan may give it: grown by some [m], without colours."""
    return Mesh(mesh.vertices * (1 + by / HALF), mesh.faces, mesh.normals)


def around(count: int, distance: float = 0.6, tilt: float = 0.5):
    """(count, 4, 4) cameras on a circle that look down at the origin."""
    poses = []
    for turn in 2 * np.pi * np.arange(count) / count:
        back = np.array([np.cos(turn) * np.cos(tilt), np.sin(turn) * np.cos(tilt), np.sin(tilt)])
        right = np.array([-np.sin(turn), np.cos(turn), 0.0])
        T = np.eye(4)
        T[:3, :3] = np.column_stack([right, np.cross(-back, right), -back])
        T[:3, 3] = distance * back
        poses.append(T)
    return np.stack(poses)


def jittered(poses, sigma_rad: float, seed: int = 0):
    """Poses as a tracker finds them, each turned by a little [rad]."""
    noise = np.random.default_rng(seed).normal(0, sigma_rad, (len(poses), 3))
    return np.stack([T @ exp([*turn, 0, 0, 0]) for T, turn in zip(poses, noise, strict=True)])


def green_room() -> Mesh:
    return box((-3, -3, -3), (3, 3, 3), GREEN)


@dataclass(frozen=True)
class Scene:
    """Things in a green room before a camera on a circle; `poses` is where it is taken to have stood."""

    recording: Recording
    poses: Trajectory


def scene(things, at=None, sigma_rad: float = 0.0, shift: int = 0) -> Scene:
    """Pictures of things (i -> list of meshes) from a circle, or from places `at` (count, 4, 4).

    With poses that are off by some radian, and colour that is registered to depth but for a shift to the right [px].
    """
    true = around(14) if at is None else at
    stamps = np.arange(len(true)) / 30

    def load(i: int) -> Frame:
        view = RayCaster(joined([green_room(), *things(i)])).view(CAMERA, true[i])
        return Frame(i, float(stamps[i]), view.depth.astype(np.float32), np.roll(view.color, shift, axis=1))

    recording = Recording(Path("made"), "made", CAMERA, stamps, load)
    return Scene(recording, Trajectory(stamps, jittered(true, sigma_rad)))
