"""The reference plane of a Kinect v1: depth follows from its raw values by numbers that each unit tells of itself."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera, Principle

NO_VALUE = 2047  # the raw value where nothing was measured
FARTHEST = 10.0  # [m] beyond, the curve runs away: one step of the raw value is a metre and more
# counts per metre of what is recorded: 0.2 mm, a seventh of the step of the raw value at 0.6 m; up to 13 m
DEPTH_SCALE = 5000.0


@dataclass(frozen=True)
class ZeroPlane:
    """The plane at which the factory took the reference image. Lengths in centimetres, as the arithmetic needs them."""

    baseline: float  # from the emitter to the infrared camera
    to_color: float  # from the infrared to the colour camera
    distance: float  # of the plane
    pixel: float  # of 1280 across; the focal length in pixels of 640 is `distance` / (2 `pixel`)
    shift: int  # constant that the device adds to its disparity, in quarters of a raw value

    def metres(self) -> NDArray[np.float32]:
        """(2048,) [m] depth of each raw value, NaN where there is none.

        m = pixel ((raw - 4 shift) / 4 - 0.375); z = distance baseline / (baseline - m): libfreenect's formula.
        """
        raw = np.arange(NO_VALUE + 1, dtype=float)
        moved = self.pixel * ((raw - 4 * self.shift) / 4 - 0.375)
        with np.errstate(divide="ignore"):
            depth = 0.01 * self.distance * self.baseline / (self.baseline - moved)
        good = (depth > 0) & (depth <= FARTHEST) & (raw < NO_VALUE)
        return np.where(good, depth, np.nan).astype(np.float32)

    def camera(self, serial: str) -> Camera:
        """The depth camera: its focal length follows from the reference plane, its centre is nominal."""
        focal = self.distance / (2 * self.pixel)
        return Camera(
            640,
            480,
            fx=focal,
            fy=focal,
            cx=319.5,
            cy=239.5,
            depth_scale=DEPTH_SCALE,
            principle=Principle.STRUCTURED_LIGHT,
            sensor="kinect-v1",
            serial=serial,
        )


# what units usually tell; within 0.9 % from 0.5 to 2 m of the OpenKinect wiki's tangent, fitted to one unit
USUAL = ZeroPlane(7.5, 2.4, 120.0, 0.1042, 200)
