"""Placing: where a surface really stands whose pose was found in the camera's own images, when the camera is wrong."""

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, exp, transform
from fusion.sensor.view import View

POINTS = 400  # spread over what is seen: they stand for the corners that somebody detected
LEAST = 6  # below, a pose is not known from points
STEPS = 5  # of Gauss and Newton: 5 % of focal length leave less than a micrometre


def found_again(true: Camera, view: View) -> Array:
    """Motion (4, 4) in the camera frame from where the surface is stated to where the true camera finds it.

    Who finds a pose in an image chooses it so that the surface's points fall on the pixels where they are seen. With
    other rays for the same pixels another pose does that: a focal length 1 % too long puts all 1 % too far away.
    """
    T = np.eye(4)
    points, seen = _spread_points(true, view)
    if len(points) < LEAST:
        return T
    for _ in range(STEPS):
        at = transform(T, points)
        z = at[:, 2:]
        if np.any(z <= 0):
            return np.eye(4)
        off = (seen - at[:, :2] / z).ravel()
        J = _jacobian(at)
        T = exp(np.linalg.lstsq(J, off, rcond=1e-9)[0]) @ T
    return T


def _spread_points(true: Camera, view: View) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points (n, 3) [m] where the surface is stated, and the true rays (n, 2) of their pixels."""
    assert view.depth is not None
    rows, columns = np.nonzero(np.isfinite(view.depth))
    some = np.linspace(0, len(rows) - 1, min(len(rows), POINTS)).astype(int)
    rows, columns = rows[some], columns[some]
    z = np.asarray(view.depth[rows, columns], float)
    rays = np.column_stack([view.camera.rays()[rows, columns], np.ones(len(z))])
    return rays * z[:, None], np.asarray(true.rays()[rows, columns], float)


def _jacobian(at: NDArray[np.float64]) -> NDArray[np.float64]:
    """(2 n, 6) change of the rays x / z and y / z of points (n, 3) under a small motion from the left."""
    x, y, z = at.T
    along = np.zeros((len(at), 2, 3))
    along[:, 0, 0] = along[:, 1, 1] = 1 / z
    along[:, 0, 2], along[:, 1, 2] = -x / z**2, -y / z**2
    turned = np.zeros((len(at), 3, 3))
    turned[:, 0, 1], turned[:, 0, 2] = z, -y
    turned[:, 1, 0], turned[:, 1, 2] = -z, x
    turned[:, 2, 0], turned[:, 2, 1] = y, -x
    return np.concatenate([along @ turned, along], axis=2).reshape(-1, 6)
