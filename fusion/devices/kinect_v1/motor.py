"""The motor in the foot: tilt, LED and accelerometer, by either of the two ways that Kinects have."""

import struct
from dataclasses import dataclass
from typing import Any

from fusion.devices.kinect_v1.commands import IN, OUT
from fusion.devices.kinect_v1.find import Parts
from fusion.errors import DeviceError

STEEPEST = 31  # [deg] from the horizon, either way; the device itself guards nothing
COUNTS_PER_G = 819
WAIT = 250  # [ms]
# what it shows: number of the motor device, and of the audio device
LEDS = {"off": (0, 1), "green": (1, 3), "red": (2, 4), "yellow": (3, None), "blink": (4, 2), "blink red": (6, None)}
STATES = {0: "stopped", 1: "at its limit", 4: "moving"}
MAGIC, REPLY = 0x06022009, 0x0A6FE000  # of the audio device's messages


@dataclass(frozen=True)
class MotorState:
    """Attributes:
    acceleration: x, y, z in units of g; at rest it points up, away from the ground.
    tilt_deg: of the camera against the horizon; None while it moves.
    moving: "stopped", "at its limit", "moving", or "" where the device does not tell.
    """

    acceleration: tuple[float, float, float]
    tilt_deg: float | None
    moving: str = ""


class Motor:
    """Moves and lights a Kinect.

    Raises:
        DeviceError: this Kinect has no motor that answers. usb.core.USBError: a transfer failed.
    """

    def __init__(self, parts: Parts) -> None:
        self._motor, self._audio, self._tag = parts.motor, parts.audio, 0
        if self._motor is None and not _speaks(self._audio):
            do = "a 1473 or 1517 needs its firmware first, which a Windows machine or libfreenect's tools load"
            raise DeviceError("this Kinect's motor does not answer", parts.name, do=do)

    def tilt(self, degrees: float) -> None:
        """Begin to tilt against the horizon, at most 31 degrees either way."""
        degrees = max(-STEEPEST, min(STEEPEST, degrees))
        if self._motor is not None:
            self._motor.ctrl_transfer(OUT, 0x31, round(2 * degrees) & 0xFFFF, 0, None, WAIT)
        else:
            self._tell(0x803B, 0, struct.pack("<i", round(degrees)))

    def light(self, what: str) -> None:
        """Light the LED: one of `LEDS`."""
        own, by_audio = LEDS[what]
        if self._motor is not None:
            self._motor.ctrl_transfer(OUT, 0x06, own, 0, None, WAIT)
        elif by_audio is not None:
            self._tell(0x10, 0, struct.pack("<i", by_audio))

    def state(self) -> MotorState:
        """Where it stands."""
        if self._motor is not None:
            data = bytes(self._motor.ctrl_transfer(IN, 0x32, 0, 0, 10, WAIT))
            if len(data) < 10:
                raise DeviceError("the motor's answer is not understood", "Kinect v1", f"{len(data)} bytes of 10")
            x, y, z, tilt, moving = struct.unpack_from(">hhhbB", data, 2)
        else:
            data = self._tell(0x8032, 0x68, b"", 104)
            x, y, z, tilt = struct.unpack_from("<4i", data, 16)
            tilt, moving = 2 * tilt, -1
        told = (x / COUNTS_PER_G, y / COUNTS_PER_G, z / COUNTS_PER_G)
        return MotorState(told, None if tilt == -128 else tilt / 2, STATES.get(moving, ""))

    def _tell(self, command: int, first: int, rest: bytes, length: int = 0) -> bytes:
        """A message to the audio device; what it answers before its acknowledgement."""
        self._tag = (self._tag + 1) & 0xFFFFFFFF
        self._audio.write(0x01, struct.pack("<4I", MAGIC, self._tag, first, command) + rest, WAIT)
        data = bytes(self._audio.read(0x81, 512, WAIT)) if length else b""
        reply = bytes(self._audio.read(0x81, 512, WAIT))
        if len(data) < length or len(reply) != 12 or struct.unpack("<3I", reply) != (REPLY, self._tag, 0):
            found = f"{len(data)} bytes, then {reply[:12].hex(' ')}"
            raise DeviceError("the motor's answer is not understood", "Kinect v1", found)
        return data


def _speaks(audio: Any) -> bool:
    """True for an audio device whose firmware runs: the boot loader has one interface."""
    return audio is not None and any(configuration.bNumInterfaces >= 2 for configuration in audio)
