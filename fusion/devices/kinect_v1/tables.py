"""What a Kinect v1 tells of itself: the reference plane, from which depth follows, and how depth meets colour."""

import struct
from dataclasses import dataclass

from fusion.devices.kinect_v1.commands import Commands
from fusion.errors import DeviceError
from fusion.recording.cameras.zero_plane import USUAL, ZeroPlane

SHIFT, REGISTRATION, PADDING = 0x00, 0x40, 0x41
AT = 94  # where the reference plane begins in the reply of the fixed parameters: a status, and 23 whole numbers


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
    # within a factor of three nothing else is a Kinect
    for value, usual in ((baseline, USUAL.baseline), (distance, USUAL.distance), (pixel, USUAL.pixel)):
        if not usual / 3 < value < usual * 3:
            raise _impossible(f"{value:g} where some {usual:g} is usual")
    return plane


@dataclass(frozen=True)
class RecordedTables:
    """What is recorded of them: the plane, the registration's 29 numbers, the padding's three."""

    zero_plane_cm: ZeroPlane
    registration: tuple[int, ...]
    padding: tuple[int, ...]


def read_tables(commands: Commands, plane: ZeroPlane) -> RecordedTables:
    """Ask the device for them."""
    registration, padding = commands.algorithm(REGISTRATION), commands.algorithm(PADDING)
    return RecordedTables(
        plane,
        struct.unpack_from(f"<{min(29, (len(registration) - 2) // 4)}i", registration, 2),
        struct.unpack_from(f"<{min(3, (len(padding) - 2) // 2)}H", padding, 2),
    )


def _impossible(found: str) -> DeviceError:
    do = "unplug it and plug it in again; if that does not help, please report it with what fusion doctor tells"
    return DeviceError("the camera's calibration cannot be used", "Kinect v1", found, do=do)
