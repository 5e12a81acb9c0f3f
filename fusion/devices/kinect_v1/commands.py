"""The camera's command channel: small messages over endpoint 0, each answered once."""

import struct
import time
from typing import Any, Protocol

from fusion.errors import DeviceError

OUT, IN = 0x40, 0xC0  # vendor requests to the device, which need no claimed interface
HEAD = struct.Struct("<2sHHH")  # magic, payload in 16-bit words, command, tag
LONGEST = 512  # bytes asked for; this length, and none at all, mean "not yet"
PATIENCE = 1.0  # [s] for a reply: the device takes a few milliseconds (guess: a hundred times that)
GET, SET, FIXED, ALGORITHM, SENSOR = 0x02, 0x03, 0x04, 0x16, 0x95
WRITE = 0x8000  # bit of a sensor register's number


class ControlPipe(Protocol):
    """What is used of pyusb's Device here."""

    def ctrl_transfer(
        self, kind: int, request: int, value: int = 0, index: int = 0, data: Any = None, timeout: int | None = None
    ) -> Any:
        """A control transfer; bytes in, or how many went out."""


class Commands:
    """Sends commands and waits for their replies; one after the other.

    Raises:
        DeviceError: no reply in time, or one of another form. usb.core.USBError: the transfer itself failed.
    """

    def __init__(self, pipe: ControlPipe, patience: float = PATIENCE) -> None:
        self.pipe, self.patience = pipe, patience
        self._tag = 0

    def ask(self, command: int, payload: bytes = b"") -> bytes:
        """The payload of the reply. Replies to earlier commands, which came too late for them, are passed over."""
        self._tag = (self._tag + 1) & 0xFFFF
        self.pipe.ctrl_transfer(OUT, 0, 0, 0, HEAD.pack(b"GM", len(payload) // 2, command, self._tag) + payload, 1000)
        limit = time.monotonic() + self.patience
        while True:
            reply = bytes(self.pipe.ctrl_transfer(IN, 0, 0, 0, LONGEST, 1000))
            if len(reply) not in (0, LONGEST) and (answer := self._payload(reply, command)) is not None:
                return answer
            if time.monotonic() > limit:
                do = "unplug it and plug it in again"
                raise DeviceError("the camera does not answer", "Kinect v1", f"no reply to command {command:#x}", do=do)
            time.sleep(0.0005)

    def _payload(self, reply: bytes, command: int) -> bytes | None:
        """What a reply holds; None where it is another command's."""
        if len(reply) < HEAD.size or reply[:2] != b"RB":
            raise _garbled(f"a reply that begins with {reply[:8].hex(' ')}")
        _, words, answered, tag = HEAD.unpack_from(reply)
        if tag != self._tag:
            return None
        if answered != command or 2 * words != len(reply) - HEAD.size:
            raise _garbled(f"command {answered:#x} with {2 * words} bytes, of which {len(reply) - HEAD.size} came")
        return reply[HEAD.size :]

    def set(self, register: int, value: int) -> None:
        """Set a parameter."""
        status = struct.unpack_from("<H", self._long(self.ask(SET, struct.pack("<HH", register, value)), 2))[0]
        if status:
            raise _garbled(f"status {status} for register {register:#x} set to {value}")

    def get(self, register: int) -> int:
        """A parameter."""
        status, value = struct.unpack_from("<HH", self._long(self.ask(GET, struct.pack("<H", register)), 4))
        if status:
            raise _garbled(f"status {status} for register {register:#x}")
        return int(value)

    def sensor(self, register: int, value: int | None = None) -> int:
        """A register of the image sensor, set where a value is given."""
        number = register if value is None else register | WRITE
        reply = self._long(self.ask(SENSOR, struct.pack("<HHH", 1, number, value or 0)), 6)
        return int(struct.unpack_from("<3H", reply)[2])

    def fixed(self) -> bytes:
        """The parameters that the factory wrote."""
        return self.ask(FIXED, bytes(10))

    def algorithm(self, number: int, resolution: int = 1, rate: int = 30) -> bytes:
        """A table of the device's own processing, behind its 16-bit status."""
        return self.ask(ALGORITHM, struct.pack("<5H", number, 0, resolution, rate, 0))

    @staticmethod
    def _long(reply: bytes, least: int) -> bytes:
        if len(reply) < least:
            raise _garbled(f"{len(reply)} bytes where {least} were due")
        return reply


def _garbled(found: str) -> DeviceError:
    return DeviceError("the camera's answer is not understood", "Kinect v1", found, do="unplug it and plug it in again")
