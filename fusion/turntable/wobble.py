"""How the axis rocks: what of freely tracked poses is no turn about one fixed axis."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Rocking:
    """The axis of a set of rotations, and how it moves."""

    axis: Array  # (3,) unit vector in the camera's frame, the mean
    # (n, 2) away from it [rad]: towards the line of sight (away from the camera), and sideways; NaN where a frame has
    # no pose
    tilt: Array
    rms: float  # root mean square of the tilt [rad]


def rocking(R_object_camera: Array, along: Array) -> Rocking:
    """The rocking of the axis seen in the frame of a camera that stands still.

    A direction in the object that comes as near as can be to standing still before the camera is the axis; an object
    that stands askew on a true bearing does not rock, wherever its own upright is.

    Args:
        R_object_camera: (n, 3, 3) rotations of the camera in the object's frame, NaN where a frame has no pose.
        along: (3,) about where the axis points in the object's frame; says which end is up.
    """
    known = np.asarray(np.isfinite(R_object_camera).all(axis=(1, 2)))
    tilt = np.full((len(known), 2), np.nan)
    if not known.any():
        return Rocking(np.array([0.0, -1.0, 0.0]), tilt, float("nan"))
    # the pair of directions, in object and camera, that the rotations bring together best
    objects, _, _ = np.linalg.svd(R_object_camera[known].mean(axis=0))
    sign = np.sign(objects[:, 0] @ along) or 1.0
    seen = np.einsum("nji,j->ni", R_object_camera[known], sign * objects[:, 0])
    mean = seen.mean(axis=0)
    mean /= np.linalg.norm(mean)
    sight = np.array([0.0, 0.0, 1.0]) - mean[2] * mean
    if np.linalg.norm(sight) < 1e-6:  # looking along the axis: any two directions will do
        sight = np.cross(mean, [1.0, 0.0, 0.0])
    sight /= np.linalg.norm(sight)
    tilt[known] = np.column_stack([seen @ sight, seen @ np.cross(mean, sight)])
    return Rocking(mean, tilt, float(np.sqrt((tilt[known] ** 2).sum(axis=1).mean())))
