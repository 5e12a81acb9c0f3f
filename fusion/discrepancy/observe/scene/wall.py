"""Wall: a recording with `distance_m` in its telemetry and no mesh shows a flat wall; its tilt is free."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.series import PixelSeries
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.mesh import Mesh
from fusion.recording.recording import Recording

LASER_M = 0.001  # guess: a laser meter and the place of the camera's origin
FREE_RAD = 0.1  # nobody measures how a wall is turned
FRAMES = 4
ROUNDS = 8
WIDE = 6.0  # half the side of the wall over its distance: it fills the picture
DENSE = 24


@dataclass(frozen=True)
class WallScene:
    """A wall before a camera in the origin: its mesh, and the recording with that pose."""

    mesh: Mesh
    recording: Recording


def wall_of(recording: Recording) -> WallScene | None:
    """The wall of a recording that says how far it is; None where none does, or nothing flat is seen."""
    distances = recording.telemetry.get("distance_m")
    if distances is None or not np.isfinite(distances).all() or np.ptp(distances) > 1e-6 or distances[0] <= 0:
        return None
    series = PixelSeries(recording.camera.shape)
    for i in range(min(FRAMES, len(recording))):
        series.add(recording[i].depth)
    depth = series.mean
    normal = _normal(recording.camera.points(depth)[np.isfinite(depth)])
    if normal is None:
        return None
    poses = np.tile(np.eye(4), (len(recording), 1, 1))
    mesh = _square(float(distances[0]), normal)
    return WallScene(mesh, replace(recording, poses=Trajectory(recording.timestamps, poses)))


def _normal(points: NDArray[np.floating]) -> NDArray[np.float64] | None:
    """Normal (3,) of the plane through most of the points (n, 3); None with too few."""
    if len(points) < 100:
        return None
    points = np.asarray(points, float)
    weight = np.ones(len(points))
    for _ in range(ROUNDS):
        middle = np.average(points, axis=0, weights=weight)
        away = (points - middle) * np.sqrt(weight)[:, None]
        normal = np.linalg.eigh(away.T @ away)[1][:, 0]
        off = np.abs((points - middle) @ normal)
        # what stands before the wall, and the floor, count less and less
        weight = 1.0 / (1.0 + (off / (2 * np.median(off) + 1e-6)) ** 2) ** 2
    return np.asarray(normal * -np.sign(normal[2]))


def _square(distance: float, normal: NDArray[np.float64]) -> Mesh:
    """A square whose plane the optical axis meets after `distance` [m], fine enough for exact rays."""
    right = np.cross([0.0, 1.0, 0.0], normal)
    right /= np.linalg.norm(right)
    down = np.cross(normal, right)
    steps = np.linspace(-WIDE, WIDE, DENSE) * distance
    s, t = np.meshgrid(steps, steps)
    vertices = np.array([0.0, 0.0, distance]) + s.reshape(-1, 1) * right + t.reshape(-1, 1) * down
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(DENSE - 1), np.arange(DENSE - 1)))
    corner = j * DENSE + i
    a, b, c, d = corner, corner + 1, corner + DENSE + 1, corner + DENSE
    faces = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])]).astype(np.int32)
    return Mesh(vertices, faces)
