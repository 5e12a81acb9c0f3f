"""Two kinds of effect that move what is seen instead of changing a depth: rays (the camera), surfaces (the rig).

A renderer applies them exactly, before it casts a ray, and names them in `View.done`; without a renderer their bias
is that of the tangent plane.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, exp, transform
from fusion.sensor.effect import Effect
from fusion.sensor.laws.surface import moved_rigidly, seen_along
from fusion.sensor.moment import Moment
from fusion.sensor.view import Image, View, stretch

POINTS = 400  # spread over what is seen: they stand for the corners that somebody detected
LEAST = 6  # below, a pose is not known from points
STEPS = 5  # of Gauss and Newton: 5 % of focal length leave less than a micrometre


@dataclass(frozen=True)
class CameraEffect(Effect, ABC):
    """The stated camera is wrong: every ray goes elsewhere."""

    not_corrected: ClassVar[str] = "use the true camera instead of the stated one"

    @abstractmethod
    def true_camera(self, stated: Camera) -> Camera:
        """The camera that took the pictures, from the stated one."""

    def bias(self, depth: Image, view: View) -> Image:
        true = self.true_camera(view.camera)
        if true == view.camera:
            return np.zeros((), depth.dtype)
        # a pose that this camera's images gave is as wrong as the camera
        motion = found_again(true, view) if view.placed_by_images else None
        seen = seen_along(depth, true.rays(), view, motion)
        if view.time_of_flight:  # the range is right, and becomes a depth along the stated ray
            seen = seen * (stretch(true) / view.stretch)
        change = seen - depth
        return np.where(np.isfinite(change), change, np.zeros((), depth.dtype))


@dataclass(frozen=True)
class RigEffect(Effect, ABC):
    """What is seen stands elsewhere than stated: a rigid motion of the surface in the camera frame."""

    not_corrected: ClassVar[str] = "it belongs to the pose of the frame, not to its depth"

    @abstractmethod
    def motion(self, moment: Moment) -> NDArray[np.float64] | None:
        """(6,) rotation [rad] about the camera, then translation [m], as `geometry.pose.exp`; None when all stands.

        A point of the surface stated at P (camera frame) stands at R P + t.
        """

    def bias(self, depth: Image, view: View) -> Image:
        motion = self.motion(view.moment)
        if motion is None:
            return np.zeros((), depth.dtype)
        change = moved_rigidly(depth, motion, view)
        return change if view.turning is None else np.where(view.turning, change, np.zeros((), depth.dtype))


def found_again(true: Camera, view: View) -> Array:
    """Motion (4, 4) in the camera frame from where the surface is stated to where the true camera finds it.

    Who finds a pose in an image chooses it so that the surface's points fall on the pixels where they are seen. With
    other rays for the same pixels another pose does that: a focal length 1 % too long puts all 1 % too far away.
    """
    T = np.eye(4)
    points, pixels = _spread_points(view)
    if len(points) < LEAST:
        return T
    seen = np.asarray(true.rays()[pixels], float)
    for _ in range(STEPS):
        at = transform(T, points)
        z = at[:, 2:]
        if np.any(z <= 0):
            return np.eye(4)
        off = (seen - at[:, :2] / z).ravel()
        J = _jacobian(at)
        T = exp(np.linalg.lstsq(J, off, rcond=1e-9)[0]) @ T
    return T


def motions_found(changes: NDArray[np.floating], view: View) -> NDArray[np.float64]:
    """(6, k) the same as small motions [rad, m], for small changes (k, h, w, 2) of the rays x/z and y/z."""
    points, (rows, columns) = _spread_points(view)
    if len(points) < LEAST:
        return np.zeros((6, len(changes)))
    off = np.asarray(changes[:, rows, columns], float).reshape(len(changes), -1)
    return np.asarray(np.linalg.lstsq(_jacobian(points), off.T, rcond=1e-9)[0])


def _spread_points(view: View) -> tuple[NDArray[np.float64], tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Points (n, 3) [m] where the surface is stated, and rows and columns (n,) of their pixels."""
    if view.depth is None:
        return np.zeros((0, 3)), (np.zeros(0, np.intp), np.zeros(0, np.intp))
    rows, columns = np.nonzero(np.isfinite(view.depth))
    some = np.linspace(0, len(rows) - 1, min(len(rows), POINTS)).astype(int)
    rows, columns = rows[some], columns[some]
    z = np.asarray(view.depth[rows, columns], float)
    rays = np.column_stack([view.camera.rays()[rows, columns], np.ones(len(z))])
    return rays * z[:, None], (rows, columns)


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
