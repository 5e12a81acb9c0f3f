"""Any mesh on a turntable."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from fusion.errors import SceneError
from fusion.mesh.files import read_mesh
from fusion.mesh.mesh import Mesh
from fusion.quantity import FAR, Quantity
from fusion.simulation.demo.demo import demo_truth, surroundings
from fusion.simulation.scene.course import checked_frames, looking_at, turning
from fusion.simulation.scene.scene import Part, Scene, StatedPoses
from fusion.simulation.scene.shapes import disc
from fusion.simulation.scene.turntable import Turntable, TurntableErrors
from fusion.simulation.scenes.panel import WARM_S

DISTANCE = Quantity("distance of the camera", "distance_m", "m", 0.0, FAR)  # 0: as the object asks for
ELEVATION = Quantity("elevation of the camera", "elevation_deg", "deg", 0.0, 90.0, signed=True)


def turntable(
    mesh: str = "",
    scale: float = 1.0,
    turns: float = 1.2,
    frames: int = 72,
    elevation_deg: float = 25.0,
    distance_m: float = 0.0,
    uneven_sd_deg: float = 0.0,
    slip_frame: int = 0,
    slip_deg: float = 0.0,
    wobble_deg: float = 0.0,
    continuous: bool = False,
    background: bool = True,
) -> Scene:
    """a mesh (file, z up; default: the demo's owl) on a turntable; scale=0.001 for millimetres"""
    checked_frames(frames)
    DISTANCE.check(distance_m)
    ELEVATION.check(elevation_deg)
    thing = read_mesh(Path(mesh)) if mesh else demo_truth()
    if mesh or scale != 1.0:  # the demo's owl stands beside the axis
        thing = placed(thing, scale)
    low, high = thing.vertices.min(axis=0), thing.vertices.max(axis=0)
    radius = float(np.hypot(*np.abs([low, high])[:, :2].max(axis=0)))
    size = max(radius, float(high[2]) / 2)
    away = distance_m or max(0.65, 4.5 * size)  # all of it within 25 degrees
    up = np.deg2rad(elevation_deg)
    centre = np.array([0.0, 0.0, high[2] / 2])
    eye = centre + away * np.array([np.cos(up), 0.0, np.sin(up)])
    errors = TurntableErrors(uneven_sd_deg, slip_frame or None, slip_deg, wobble_deg)
    table = Turntable(degrees_per_frame=360.0 * turns / frames, frames=frames, errors=errors)
    plate = Part(disc(max(0.15, 1.15 * radius), -0.012, -0.0005, _plain), turns=True, scanned=False)
    still = [Part(part, scanned=False) for part in surroundings()] if background and size < 0.2 else []
    return Scene(
        name="turntable",
        parts=(Part(thing, turns=True), plate, *still),
        course=turning(table, looking_at(eye, centre), start_s=WARM_S, continuous=continuous),
        poses=StatedPoses("nominal", 0.0, 0.0),
        ambient_lux=300.0,
        color=thing.colors is not None,
    )


def placed(mesh: Mesh, scale: float) -> Mesh:
    """The mesh in metres, standing on z = 0 with the middle of its box on the axis."""
    if not len(mesh.faces):
        raise SceneError("a point cloud cannot be seen", "the scene's mesh", "no faces", "a mesh")
    if not (np.isfinite(scale) and scale > 0):
        raise SceneError("the scale cannot be used", found=scale, expected="above 0")
    vertices = mesh.vertices * scale
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    if not 0.001 < np.linalg.norm(high - low) < 10:
        size = " x ".join(f"{x:.3g}" for x in high - low)
        raise SceneError(
            "the mesh has no size for a turntable", found=f"{size} m", expected="up to 10 m", do="set scale"
        )
    return replace(mesh, vertices=vertices - [*(low + high)[:2] / 2, low[2]])


def _plain(points: np.ndarray) -> np.ndarray:
    return np.full((len(points), 3), 205.0)
