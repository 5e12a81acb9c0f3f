"""What poses in a file may mean: which way they map, along which axes of the camera, in which order of numbers."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fusion.geometry.pose import Array, from_tum, inverse, other_axes, to_tum

# (4, 4) OpenCV's axes of a camera (x right, y down, z forward) in those of a robot's body (x forward, y left, z up;
# ROS, REP 103)
T_BODY_OPTICAL = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
UP = np.diag([1.0, -1.0, 1.0, 1.0])  # y down for y up, which makes a left-handed frame a right-handed one


@dataclass(frozen=True)
class PoseConvention:
    """One way in which programs write poses."""

    seen: str  # what the poses are read as
    meant: str  # what poses look like that fit when they are read so
    read: Callable[[Array], Array]  # poses (..., 4, 4) as written, to OpenCV's: camera to world, y down, z forward


def _with_w_first(T: Array) -> Array:
    """Poses (..., 4, 4) whose quaternions were read as x, y, z, w, and are w, x, y, z."""
    out = T.reshape(-1, 4, 4).copy()
    for k in np.flatnonzero(np.isfinite(out).all(axis=(1, 2))):
        v = to_tum(out[k])
        out[k] = from_tum([*v[:3], *v[4:], v[3]])
    return out.reshape(T.shape)


CONVENTIONS = {
    "opencv": PoseConvention("as stated", "camera to world with y down and z forward", np.asarray),
    "world-to-camera": PoseConvention("inverted", "world to camera", inverse),
    "opengl": PoseConvention(
        "with the camera's y up and z back", "those of OpenGL, Blender, NeRF or ARKit: camera to world", other_axes
    ),
    "opengl-view": PoseConvention(
        "inverted, with the camera's y up and z back", "OpenGL's view matrices", lambda T: other_axes(inverse(T))
    ),
    "ros": PoseConvention(
        "as a robot's body, x forward and z up", "frames of ROS that are no optical ones", lambda T: T @ T_BODY_OPTICAL
    ),
    "unity": PoseConvention("left-handed with y up", "those of Unity", lambda T: UP @ T @ UP),
    "w-first": PoseConvention("with w first in the quaternions", "lines of tx ty tz qw qx qy qz", _with_w_first),
}
