"""The room: 4 x 4 x 2.5 m with seven boxes and seven balls, met exactly by rays."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SIZE = np.array([4.0, 4.0, 2.5])
BOXES = np.array(  # corner, size [m]
    [
        [0.1, 0.1, 0.0, 1.6, 0.6, 0.75], [3.0, 0.3, 0.0, 0.8, 0.5, 1.8], [0.2, 2.4, 0.0, 0.9, 1.5, 0.45],
        [2.6, 3.2, 0.0, 1.2, 0.7, 0.9], [1.5, 1.6, 0.0, 0.9, 0.6, 0.42], [0.3, 0.25, 0.75, 0.5, 0.3, 0.35],
        [1.1, 0.2, 0.75, 0.3, 0.25, 0.25],
    ]
)  # fmt: skip
BALLS = np.array(  # centre, radius [m]
    [
        [1.7, 1.8, 0.57, 0.15], [2.2, 1.95, 0.52, 0.10], [0.6, 3.0, 0.65, 0.20], [3.3, 3.5, 1.05, 0.15],
        [3.5, 2.0, 0.30, 0.30], [2.5, 0.6, 0.25, 0.25], [3.3, 0.5, 1.95, 0.15],
    ]
)  # fmt: skip


def depth(T_world_camera: Array, rays: Array) -> Array:
    """Planar depth (h, w) [m] along rays (h, w, 3) with z = 1."""
    eye, d = T_world_camera[:3, 3], rays.reshape(-1, 3) @ T_world_camera[:3, :3].T
    with np.errstate(divide="ignore", invalid="ignore"):
        _, nearest = _slabs(eye, d, np.zeros(3), SIZE)  # where the ray leaves the room
        for box in BOXES:
            enter, leave = _slabs(eye, d, box[:3], box[:3] + box[3:])
            nearest = np.where((enter > 0) & (enter <= leave), np.minimum(nearest, enter), nearest)
        for ball in BALLS:
            b, c = d @ (eye - ball[:3]), (eye - ball[:3]) @ (eye - ball[:3]) - ball[3] ** 2
            a = np.einsum("ij,ij->i", d, d)
            t = (-b - np.sqrt(b * b - a * c)) / a
            nearest = np.where(t > 0, np.minimum(nearest, t), nearest)
    return nearest.reshape(rays.shape[:2])


def distance(points: Array) -> Array:
    """Unsigned distance (n,) [m] of points (n, 3) to the nearest face or ball; inner faces count, as in the images
    nobody sees them and no fused surface comes near them."""
    nearest = np.abs(_to_box(points, np.zeros(3), SIZE))
    for box in BOXES:
        nearest = np.minimum(nearest, np.abs(_to_box(points, box[:3], box[:3] + box[3:])))
    for ball in BALLS:
        nearest = np.minimum(nearest, np.abs(np.linalg.norm(points - ball[:3], axis=1) - ball[3]))
    return nearest


def _to_box(points: Array, low: Array, high: Array) -> Array:
    """Signed distance (n,) to a solid box, negative inside."""
    q = np.abs(points - (low + high) / 2) - (high - low) / 2
    return np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0)


def _slabs(eye: Array, d: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Where rays enter and leave a box."""
    a, b = (low - eye) / d, (high - eye) / d
    return np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
