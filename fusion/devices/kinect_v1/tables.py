"""What a Kinect v1 tells of itself: the reference plane, from which depth follows, and how depth meets colour."""

import struct
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.devices.kinect_v1.commands import Commands
from fusion.errors import DeviceError
from fusion.geometry.camera import Camera

NO_VALUE = 2047  # the raw value where nothing was measured
FARTHEST = 10.0  # [m] beyond, the curve runs away: one step of the raw value is a metre and more
SHIFT, REGISTRATION, PADDING = 0x00, 0x40, 0x41
AT = 94  # where the reference plane begins in the reply of the fixed parameters: a status, and 23 whole numbers
# counts per metre of what is recorded: 0.2 mm, a seventh of the step of the raw value at 0.6 m; up to 13 m
DEPTH_SCALE = 5000.0


@dataclass(frozen=True)
class ZeroPlane:
    """The plane at which the factory took the reference image. Lengths in centimetres, as the arithmetic needs them.

    Attributes:
        baseline: from the emitter to the infrared camera.
        to_color: from the infrared to the colour camera.
        distance: of the plane.
        pixel: of 1280 across; the focal length in pixels of 640 is `distance` / (2 `pixel`).
        shift: constant that the device adds to its disparity, in quarters of a raw value.
    """

    baseline: float
    to_color: float
    distance: float
    pixel: float
    shift: int

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
            principle="structured_light",
            sensor="kinect-v1",
            serial=serial,
        )


def read_zero_plane(commands: Commands) -> ZeroPlane:
    """Ask the device for it. Raises DeviceError where it tells what cannot be."""
    fixed = commands.fixed()
    if len(fixed) < AT + 16:
        raise _impossible(f"{len(fixed)} bytes of fixed parameters")
    baseline, to_color, distance, pixel = struct.unpack_from("<4f", fixed, AT)
    reply = commands.algorithm(SHIFT)
    if len(reply) < 4:
        raise _impossible(f"{len(reply)} bytes of the constant shift")
    plane = ZeroPlane(baseline, to_color, distance, pixel, struct.unpack_from("<H", reply, 2)[0])
    # typical: 7.5, 120, 0.1042; within a factor of three nothing else is a Kinect
    for value, usual in ((baseline, 7.5), (distance, 120.0), (pixel, 0.1042)):
        if not usual / 3 < value < usual * 3:
            raise _impossible(f"{value:g} where some {usual:g} is usual")
    return plane


def read_tables(commands: Commands, plane: ZeroPlane) -> dict[str, Any]:
    """Everything that is recorded of them: the plane, the registration's 29 numbers, the padding's three."""
    registration, padding = commands.algorithm(REGISTRATION), commands.algorithm(PADDING)
    return {
        "zero_plane_cm": asdict(plane),
        "registration": list(struct.unpack_from(f"<{min(29, (len(registration) - 2) // 4)}i", registration, 2)),
        "padding": list(struct.unpack_from(f"<{min(3, (len(padding) - 2) // 2)}H", padding, 2)),
    }


def _impossible(found: str) -> DeviceError:
    do = "unplug it and plug it in again; if that does not help, please report it with what fusion doctor tells"
    return DeviceError("the camera's calibration cannot be used", "Kinect v1", found, do=do)
