"""A small clean recording of a room corner, with true poses: what every planted defect starts from."""

from dataclasses import replace

import numpy as np

from fusion.geometry.camera import Camera
from fusion.geometry.pose import about_axis, pose
from fusion.geometry.trajectory import Trajectory
from fusion.recording.recording import Frame

CAMERA = Camera(160, 120, 130.0, 130.0, 79.5, 59.5, depth_scale=1000.0, principle="itof", sensor="test")
# walls of the room: n . p = d in the world
WALLS = [([0, 0, 1], 1.9), ([0, 1, 0], 0.9), ([-1, 0, 0], 1.6), ([1, 0, 0], 2.2), ([0, -1, 0], 1.4)]


def poses(count: int) -> np.ndarray:
    """(count, 4, 4) a camera that pans and moves."""
    turns = np.linspace(-0.25, 0.25, count)
    return np.stack(
        [about_axis([0, 0, 0], [0.2, 1, 0.1], a) @ pose(np.eye(3), [0.8 * a, 0.3 * a, 1.5 * a]) for a in turns]
    )


def depth(T: np.ndarray, camera: Camera = CAMERA, seed: int = 0) -> np.ndarray:
    """Planar z [m] of the room seen from a pose, with 2 mm noise and a hole."""
    rays = np.dstack([camera.rays(), np.ones(camera.shape)]) @ T[:3, :3].T
    z = np.full(camera.shape, np.inf)
    for normal, distance in WALLS:
        across = rays @ np.array(normal, float)
        along = (distance - np.array(normal) @ T[:3, 3]) / np.where(across > 1e-6, across, np.nan)
        z = np.fmin(z, along)
    z += np.random.default_rng(seed).normal(0, 0.002, z.shape)
    z[40:50, 60:80] = np.nan
    return z.astype(np.float32)


def frames(count: int = 12, color: bool = False, ir: bool = False) -> list[Frame]:
    """Frames of the room at 30 Hz."""
    made = [Frame(i, 100 + i / 30, depth(T, seed=i)) for i, T in enumerate(poses(count))]
    random = np.random.default_rng(5)
    if color:
        made = [replace(f, color=random.integers(0, 256, (*CAMERA.shape, 3), np.uint8)) for f in made]
    if ir:
        made = [replace(f, ir=random.integers(0, 60000, CAMERA.shape).astype(np.uint16)) for f in made]
    return made


def trajectory(count: int = 12) -> Trajectory:
    """The true poses of `frames(count)`."""
    return Trajectory(100 + np.arange(count) / 30, poses(count))
