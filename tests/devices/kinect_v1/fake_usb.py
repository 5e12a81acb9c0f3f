"""A Kinect's USB calls, faked at the level of Python: enough of pyusb's Device and of the driver's port for tests.

The emulator in tests/devices/emulator is another thing: it answers real libusb, and knows nothing of this.
"""

import struct
import threading
from dataclasses import dataclass, field

import numpy as np

SERIAL = "A00365A12345678A"
PLANE = (7.5, 2.4, 120.0, 0.1042)
SHIFT = 200


class USBError(OSError):
    """As pyusb's."""

    def __init__(self, text: str, number: int) -> None:
        super().__init__(number, text)


@dataclass
class FakeDevice:
    """A device as pyusb tells of it; the camera answers commands."""

    idProduct: int = 0x02AE
    bus: int = 1
    address: int = 5
    port_numbers: tuple[int, ...] | None = (2, 1)
    serial: str | None = SERIAL
    idVendor: int = 0x045E
    bcdDevice: int = 0x010B
    late: int = 0  # how often a reply is asked for before it is there
    stale: list[bytes] = field(default_factory=list)
    registers: dict[int, int] = field(default_factory=dict)
    sent: list[tuple] = field(default_factory=list)
    garble: str = ""
    error: Exception | None = None
    _reply: bytes = b""
    _asked: int = 0

    @property
    def iSerialNumber(self):
        return 3 if self.serial is not None else 0

    @property
    def serial_number(self):
        if self.serial == "secret":
            raise ValueError("The device has no langid (permission issue, no string descriptors supported or ...)")
        return self.serial

    def ctrl_transfer(self, kind, request, value=0, index=0, data=None, timeout=None):
        if self.error is not None:
            raise self.error
        self.sent.append((kind, request, value, index, data))
        if kind == 0x40:
            self._reply, self._asked = self._answer(bytes(data or b"")), 0
            return len(data or b"")
        if request != 0:
            return b"\x22" if request == 0x10 else struct.pack("<2x3sssssbB", b"", b"", b"", b"", b"", 0, 0)
        if self.stale:
            return self.stale.pop(0)
        self._asked += 1
        return b"" if self._asked <= self.late else self._reply

    def _answer(self, message: bytes) -> bytes:
        magic, words, command, tag = struct.unpack_from("<2sHHH", message)
        assert magic == b"GM"
        assert 2 * words == len(message) - 8
        payload = message[8:]
        if command == 0x03:
            register, value = struct.unpack("<HH", payload)
            self.registers[register] = value
            answer = struct.pack("<H", 0)
        elif command == 0x02:
            answer = struct.pack("<HH", 0, self.registers.get(struct.unpack("<H", payload)[0], 0))
        elif command == 0x04:
            answer = struct.pack("<H", 0) + bytes(92) + struct.pack("<4f", *PLANE) + bytes(212)
        elif command == 0x16:
            answer = {0x00: struct.pack("<HH", 0, SHIFT), 0x40: bytes(118), 0x41: bytes(8)}[payload[0]]
        else:
            raise AssertionError(command)
        if self.garble == "magic":
            return struct.pack("<2sHHH", b"XX", len(answer) // 2, command, tag) + answer
        if self.garble == "length":
            return struct.pack("<2sHHH", b"RB", len(answer) // 2 + 1, command, tag) + answer
        return struct.pack("<2sHHH", b"RB", len(answer) // 2, command, tag) + answer


def packed(values: np.ndarray, bits: int) -> bytes:
    """Values as one stream of bits, the highest first: by numpy's own packing."""
    return np.packbits((values.reshape(-1, 1) >> np.arange(bits - 1, -1, -1)) & 1).tobytes()


def packets_of(data: bytes, base: int, payload: int, ticks: int, sequence: int) -> list[bytes]:
    """A frame's packets, numbered from `sequence`."""
    parts = [data[i : i + payload] for i in range(0, len(data), payload)]
    made = []
    for i, part in enumerate(parts):
        kind = 1 if i == 0 else 5 if i == len(parts) - 1 else 2
        made.append(struct.pack("<2sBBBBHI", b"RB", 0, base + kind, 0, (sequence + i) % 256, 0, ticks) + part)
    return made


class FakePort:
    """In place of the driver's port: a thread that feeds frames, as long as the camera's registers say so."""

    script: list = []  # noqa: RUF012 - what each opening does in turn: "run", "silent", "gone after N"
    camera: FakeDevice = FakeDevice()
    opened = 0

    def __init__(self, bus, address, alternate=0):
        cls = type(self)
        self.plan = cls.script[min(cls.opened, len(cls.script) - 1)] if cls.script else "run"
        cls.opened += 1
        self.trouble, self.feeds, self.closing = "", {}, threading.Event()
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def ctrl_transfer(self, *asked):
        return self.camera.ctrl_transfer(*asked)

    def listen(self, endpoint, feed):
        self.feeds[endpoint] = feed

    def close(self):
        self.closing.set()
        self.thread.join()

    def run(self):
        sequence, number = 0, 0
        while not self.closing.wait(1 / 60):
            registers = self.camera.registers
            if self.plan == "silent" or not (registers.get(6) == 2 and registers.get(5)):
                continue
            if self.plan.startswith("gone") and number == int(self.plan.split()[-1]):
                self.trouble = "the camera was unplugged"
                return
            colors = np.full(307_200, number % 256, np.uint8).tobytes()
            self.feeds[0x81]([(0, p) for p in packets_of(colors, 0x80, 1908, 2_000_000 * number, number * 162)])
            made = packets_of(packed(np.full(8, 600 + number), 11) * 38_400, 0x70, 1748, 2_000_000 * number, sequence)
            sequence += len(made)
            number += 1
            self.feeds[0x82]([(0, p) for p in made])
