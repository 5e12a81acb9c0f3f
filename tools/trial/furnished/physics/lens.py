"""Cameras: pixel centres at whole numbers, OpenCV's five numbers of distortion."""

from dataclasses import dataclass

import numpy as np

from tools.trial.furnished.physics.poses import Array


@dataclass(frozen=True)
class StatedCamera:
    """`scale`: counts per metre of the depth images."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, ...]
    scale: float
    principle: str = ""


def directions(camera: StatedCamera, du: float = 0.0, dv: float = 0.0) -> Array:
    """(h, w, 3) rays with z = 1 through the pixels' centres, shifted by (du, dv) [px]."""
    u, v = np.meshgrid(np.arange(camera.width, dtype=float), np.arange(camera.height, dtype=float))
    seen_x, seen_y = (u + du - camera.cx) / camera.fx, (v + dv - camera.cy) / camera.fy
    k1, k2, p1, p2, k3 = camera.distortion
    x, y = seen_x.copy(), seen_y.copy()
    for _ in range(80 if any(camera.distortion) else 0):  # a fixed point of OpenCV's forward model
        q = x * x + y * y
        c = 1 + q * (k1 + q * (k2 + q * k3))
        x, y = (
            (seen_x - 2 * p1 * x * y - p2 * (q + 2 * x * x)) / c,
            (seen_y - p1 * (q + 2 * y * y) - 2 * p2 * x * y) / c,
        )
    flat = np.stack([x, y], -1)
    return np.concatenate([flat, np.ones((*flat.shape[:2], 1))], -1)
