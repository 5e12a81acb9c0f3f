"""Poses: (4, 4) from the camera's frame, x right, y down, z forward, to the world's, z up."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[Any]


def moved(step: Array) -> Array:
    """(4, 4) a shift [m] by the first three numbers, a turn [rad] about the last three."""
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec(step[3:]).as_matrix()
    T[:3, 3] = step[:3]
    return T


def looking(eye: Array, at: Array, roll: float) -> Array:
    """(4, 4) a camera at `eye` (3,) that looks at `at` (3,), turned about its axis [rad]."""
    z = np.asarray(at, float) - eye
    z /= np.linalg.norm(z)
    x = np.cross(z, [0, 0, 1.0])
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    T = np.eye(4)
    T[:3, :3] = np.stack([x, y, z], 1) @ Rotation.from_euler("z", roll).as_matrix()
    T[:3, 3] = eye
    return T
