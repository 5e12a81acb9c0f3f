"""The three units of a Kinect for Xbox 360 (1414) behind its hub: what each answers to a control request.

`control` takes the numbers of a request and the bytes sent, and gives the bytes that come back, or a negative errno.
"""

import struct
import time

from command_channel import Commands
from drawn import BayerRoll, depth_roll, infrared_roll
from identity import EPIPE, Endpoint, Identity
from stream import Stream

LATE_S = 0.4  # how long a late reply takes


class Camera:
    """045e:02ae. Endpoint 0x81 is the image (Bayer or IR), 0x82 the depth."""

    def __init__(self, serial: str, fault: str) -> None:
        ends = tuple(Endpoint(address, 1, 0x0BC0) for address in (0x81, 0x82))
        self.identity = Identity(0x02AE, 0x010B, "Xbox NUI Camera", serial, ends, 16)
        # the image's stamps are 1/600 s after those of the depth (a guess: nothing says that they are equal)
        self.streams = {0x81: Stream(0x80, 1908, 100_000, fault), 0x82: Stream(0x70, 1748, 0, fault)}
        self._rolls = {2: depth_roll(), 1: BayerRoll(), 3: infrared_roll()}
        self._fault, self._requests = fault, 0
        self._commands = Commands(self._changed)
        self._reply, self._ready, self._polled = b"", 0.0, False

    def _changed(self, register: int, value: int) -> None:
        endpoint = {0x05: 0x81, 0x06: 0x82}.get(register)
        if endpoint is None:
            return
        roll = self._rolls.get(value) if value in ((1, 3) if endpoint == 0x81 else (2,)) else None
        if roll is None:
            self.streams[endpoint].stop()
        else:
            self.streams[endpoint].start(roll)

    def control(self, kind: int, request: int, value: int, _index: int, length: int, sent: bytes) -> bytes | int:
        if kind == 0x40 and request == 0:
            return self._asked(sent)
        if kind == 0xC0 and request == 0:
            return self._answered(length)
        return self.identity.standard(kind, request, value)

    def _asked(self, sent: bytes) -> bytes | int:
        self._requests += 1
        if self._fault == "stall" and self._requests % 3 == 0:
            return -EPIPE
        reply = self._commands.answer(sent) or b""
        if self._fault == "reply-magic" and self._requests % 3 == 0:
            reply = b"XX" + reply[2:]
        if self._fault == "mute":
            reply = b""
        self._ready = time.monotonic() + (LATE_S if self._fault == "late" else 0.0)
        self._reply, self._polled = reply, False
        return b""

    def _answered(self, length: int) -> bytes:
        """Nothing at the first try, as a camera that is still at work; then the reply, once."""
        if not self._polled or time.monotonic() < self._ready:
            self._polled = True
            return b""
        reply, self._reply = self._reply[:length], b""
        return reply


class Motor:
    """045e:02b0: tilt, LED, accelerometer. It reaches its angle after as many degrees times 20 ms (a guess)."""

    streams: dict = {}  # noqa: RUF012

    def __init__(self, fault: str) -> None:
        self.identity = Identity(0x02B0, 0x0105, "Xbox NUI Motor", "", (), 100)
        self._fault, self._requests = fault, 0
        self._from, self._to, self._moved = 0, 0, 0.0
        self.led = 0

    def control(self, kind: int, request: int, value: int, _index: int, _length: int, _sent: bytes) -> bytes | int:
        if kind in (0x40, 0xC0):
            self._requests += 1
            if self._fault == "stall" and self._requests % 3 == 0:
                return -EPIPE
        if (kind, request) == (0xC0, 10):
            return b"\x22"
        if (kind, request) == (0x40, 31):
            self._from, self._to, self._moved = (
                self._to,
                struct.unpack("<h", struct.pack("<H", value))[0],
                time.monotonic(),
            )
            return b""
        if (kind, request) == (0x40, 6):
            self.led = value
            return b""
        if (kind, request) == (0xC0, 32):
            return self._state()
        return self.identity.standard(kind, request, value)

    def _state(self) -> bytes:
        """Ten bytes; gravity is (12, 819, -25) counts, a camera that stands nearly upright."""
        moving = time.monotonic() - self._moved < 0.01 * abs(self._to - self._from)
        at_limit = abs(self._to) >= 62
        tilt = -128 if moving else max(-62, min(62, self._to))
        return struct.pack(">BBhhhbB", 0, 0, 12, 819, -25, tilt, 4 if moving else 1 if at_limit else 0)


class Audio:
    """045e:02ad: there, and nothing more."""

    streams: dict = {}  # noqa: RUF012

    def __init__(self, serial: str) -> None:
        ends = (Endpoint(0x01, 2, 512), Endpoint(0x81, 2, 512), Endpoint(0x02, 1, 76), Endpoint(0x82, 1, 524))
        self.identity = Identity(0x02AD, 0x0100, "Xbox NUI Audio", serial, ends, 500)

    def control(self, kind: int, request: int, value: int, _index: int, _length: int, _sent: bytes) -> bytes | int:
        return self.identity.standard(kind, request, value)


class Hub:
    """The hub inside, 0409:005a in the notes' lsusb; here only a parent that the three share."""

    streams: dict = {}  # noqa: RUF012

    def __init__(self) -> None:
        self.identity = Identity(0x02C2, 0x0100, "Hub", "", (), 100)

    def control(self, kind: int, request: int, value: int, _index: int, _length: int, _sent: bytes) -> bytes | int:
        return self.identity.standard(kind, request, value)
