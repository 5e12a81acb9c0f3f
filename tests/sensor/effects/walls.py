"""Plane walls, and a frontal step, as views that can be written down without a renderer."""

import numpy as np

from fusion.geometry.camera import Camera
from fusion.sensor.view import Edges, View, incidence_of

CAMERA = Camera(65, 49, 60.0, 60.0, 32.0, 24.0)


def wall(principle: str, normal=(0.0, 0.0, -1.0), distance: float = 1.5, **more) -> View:
    """A plane through (0, 0, distance) [m]; float64."""
    camera = Camera(**{**vars(CAMERA), "principle": principle})
    n = np.asarray(normal, float) / np.linalg.norm(normal)
    rays = camera.rays().astype(float)
    depth = distance * n[2] / (rays @ n[:2] + n[2])
    normals = np.broadcast_to(n, (*depth.shape, 3))
    return View(camera, depth, incidence_of(normals, camera), normals, **more)


def step(principle: str, at: float, near: float, far: float, *, light: float = 1.0, velocity=None) -> View:
    """A near half left of the column `at` [px] before a far wall, both frontal.

    Args:
        light: amplitude of the near half over that of the far one.
        velocity: (3,) of the near half [m/s]; the far one stands still.
    """
    camera = Camera(**{**vars(CAMERA), "principle": principle})
    u = np.broadcast_to(np.arange(camera.width, dtype=float), camera.shape)
    left = u < at
    edges = Edges(
        np.abs(u - at),
        np.where(left, 0.0, np.pi),
        np.where(left, far - near, near - far),
        np.where(left, 1 / light, light),
    )
    moving = None if velocity is None else np.where(left[..., None], velocity, 0.0)
    return View(camera, np.where(left, near, far), edges=edges, velocity=moving)
