"""Rigid poses as 4x4 matrices, named by what they map: `T_world_camera` takes camera points to the world."""

from math import isfinite

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def pose(rotation: ArrayLike, translation: ArrayLike) -> Array:
    """The pose (4, 4) with a rotation matrix (3, 3) and a translation (3,) in metres."""
    T = np.eye(4)
    T[:3, :3] = rotation
    T[:3, 3] = translation
    return T


def inverse(T: Array) -> Array:
    """Inverse of rigid poses (..., 4, 4)."""
    out = np.zeros_like(T)
    R = np.swapaxes(T[..., :3, :3], -1, -2)
    out[..., :3, :3] = R
    out[..., :3, 3] = -np.einsum("...ij,...j->...i", R, T[..., :3, 3])
    out[..., 3, 3] = 1.0
    return out


def other_axes(T: Array) -> Array:
    """Poses (..., 4, 4) camera to world with the camera's y and z axes turned about: OpenCV's axes (y down, z forward)
    for those of OpenGL and ARKit (y up, z back), and the other way round."""
    return np.asarray(T) * np.array([1.0, -1.0, -1.0, 1.0])


def transform(T: Array, points: Array) -> Array:
    """Points (..., 3) moved by one pose (4, 4)."""
    return points @ T[:3, :3].T + T[:3, 3]


def exp(twist: ArrayLike) -> Array:
    """Pose of a twist (6,) = rotation vector [rad], then translation [m].

    The translation is applied as it is (a retraction, not the exponential's coupled translation):
    composed from the left it is a rotation about the origin and then a shift.
    """
    xi = np.asarray(twist, float)
    return pose(rotation(xi[:3]), xi[3:])


def rotation(vector: ArrayLike) -> Array:
    """Rotation matrices (..., 3, 3) of rotation vectors (..., 3) [rad] (Rodrigues; also of none and very small ones).

    Not by scipy, whose import takes a quarter of the time to a first result.
    """
    x, y, z = np.moveaxis(np.asarray(vector, float), -1, 0)
    zero, turn = np.zeros_like(x), np.sqrt(x * x + y * y + z * z)[..., None, None]
    K = np.moveaxis(np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]), (0, 1), (-2, -1))
    return np.asarray(np.eye(3) + np.sinc(turn / np.pi) * K + 0.5 * np.sinc(turn / (2 * np.pi)) ** 2 * (K @ K))


def angle(T: Array) -> float:
    """Rotation angle of a pose [rad], 0 to pi."""
    R = T[:3, :3]
    sine = np.linalg.norm([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return float(np.arctan2(sine, np.trace(R) - 1))


def about_axis(point: ArrayLike, direction: ArrayLike, angle_rad: float) -> Array:
    """The pose (4, 4) that turns right-handed about a line by an angle [rad]."""
    p = np.asarray(point, float)
    d = np.asarray(direction, float)
    R = rotation(d / np.linalg.norm(d) * angle_rad)
    return pose(R, p - R @ p)


def from_tum(values: ArrayLike) -> Array:
    """Pose of TUM's `tx ty tz qx qy qz qw` (7,) (metres, unit quaternion, scalar last)."""
    from scipy.spatial.transform import Rotation

    v = np.asarray(values, float)
    return pose(Rotation.from_quat(v[3:7]).as_matrix(), v[:3])


def to_tum(T: Array) -> Array:
    """TUM's `tx ty tz qx qy qz qw` (7,) of a pose, with qw >= 0."""
    from scipy.spatial.transform import Rotation

    return np.concatenate([T[:3, 3], Rotation.from_matrix(T[:3, :3]).as_quat(canonical=True)])


def is_rigid(T: Array, tolerance: float = 1e-3) -> bool:
    """True when a (4, 4) matrix is finite, orthonormal, right-handed and has the last row 0 0 0 1."""
    if T.shape != (4, 4):
        return False
    # in plain numbers, as every frame asks: numpy takes 20 us for steps this small, ten times that with cold caches
    a, b, c, x, d, e, f, y, g, h, i, z, *last = T.ravel().tolist()
    along = a * a + b * b + c * c - 1, d * d + e * e + f * f - 1, g * g + h * h + i * i - 1
    across = a * d + b * e + c * f, a * g + b * h + c * i, d * g + e * h + f * i
    off = *along, *across, last[0], last[1], last[2], last[3] - 1
    volume = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    return isfinite(x + y + z) and volume > 0 and all(abs(value) < tolerance for value in off)
