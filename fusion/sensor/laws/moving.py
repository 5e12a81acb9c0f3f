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
from fusion.sensor.effect import Effect
from fusion.sensor.laws.placing import found_again
from fusion.sensor.laws.surface import moved_rigidly, seen_along
from fusion.sensor.moment import Moment
from fusion.sensor.view import Image, View, stretch


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
        motion = found_again(true, view) if view.placed_by_images and view.depth is not None else None
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
