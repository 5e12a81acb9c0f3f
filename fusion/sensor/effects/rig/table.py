"""The turntable in the camera frame: its directions, and motions about it."""

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import Array, exp
from fusion.sensor.moment import Moment


def table_frame(moment: Moment) -> Array | None:
    """(3, 3) unit rows in the camera frame: in the plate towards the camera, in the plate, out of the plate.

    The second is the axis times the first, so that angles from the first to the second count right-handed about the
    axis. A camera that looks down the axis is nowhere in the plate: then the first is where its image's bottom points.
    None when there is no table.
    """
    if moment.axis_point is None or moment.axis_direction is None or not np.any(moment.axis_direction):
        return None
    axis = np.asarray(moment.axis_direction, float)
    axis = axis / np.linalg.norm(axis)
    to_camera = -np.asarray(moment.axis_point, float)
    flat = to_camera - (to_camera @ axis) * axis
    if np.linalg.norm(flat) < 1e-6 * np.linalg.norm(to_camera):
        flat = np.array([0.0, 1.0, 0.0]) - axis[1] * axis
    first = flat / np.linalg.norm(flat)
    return np.array([first, np.cross(axis, first), axis])


def turned_about(point: NDArray[np.floating], rotation: NDArray[np.floating]) -> Array:
    """The motion (6,), as `RigEffect.motion`, of a turn by a rotation vector (3,) [rad] about a point (3,) [m]."""
    point = np.asarray(point, float)
    R = exp([*rotation, 0.0, 0.0, 0.0])[:3, :3]
    return np.concatenate([rotation, point - R @ point])
