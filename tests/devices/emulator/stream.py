"""Frames as isochronous packets: one packet, or none, for each microframe of 125 us of the device's clock.

Frame n begins at n / 30 s after power-on; packet k of it is sent in the k-th microframe of the frame; the microframes
that are left until the next frame are empty. Header of 12 bytes and flags: notes of the protocol, section 4.
"""

import struct

MICROFRAMES = 8000  # a second
RATE = 30
TICKS = 60_000_000  # of the time stamp a second (reported widely, not by Microsoft)
FIRST_STAMP = 4_200_000_000  # so that the 32 bits run over after 47 frames, which a driver must survive
EVERY, AT = 10, 3  # faults of packets are in frames n with n mod 10 = 3 ...
SLOT = 50  # ... at packet 50


def first_microframe(number: int) -> int:
    return -(-number * MICROFRAMES // RATE)


def stamp(number: int, offset: int) -> int:
    return (FIRST_STAMP + number * (TICKS // RATE) + offset) % 2**32


class Stream:
    """One endpoint. `cursor` is the microframe that is sent next; nothing is sent before `start` or after `stop`."""

    def __init__(self, base: int, payload: int, stamp_offset: int, fault: str) -> None:
        self._base, self._payload, self._offset, self._fault = base, payload, stamp_offset, fault
        self._sequence = 0
        self._number, self._packets = -1, []
        self._roll = None
        self.cursor = 0
        self.sent_frames = 0

    def start(self, roll) -> None:
        self._roll, self._number, self._packets = roll, -1, []

    def stop(self) -> None:
        self._roll = None

    @property
    def running(self) -> bool:
        return self._roll is not None

    def next_packet(self) -> tuple[bytes, int]:
        """The bytes of the next microframe, and the status that USB gives for them (0, or a negative errno)."""
        microframe = self.cursor
        self.cursor += 1
        if self._roll is None:
            return b"", 0
        number = microframe * RATE // MICROFRAMES
        slot = microframe - first_microframe(number)
        if slot == 0:  # a stream that starts in the middle of a frame waits for the next
            self._number, self._packets = number, self._made(number)
            self.sent_frames += 1
        if number != self._number or slot >= len(self._packets):
            return b"", 0
        return self._packets[slot]

    def skip(self, microframes: int) -> None:
        """Microframes that nobody listened to; their frames are made all the same, sequence numbers run on."""
        for _ in range(microframes):
            self.next_packet()

    def _made(self, number: int) -> list[tuple[bytes, int]]:
        data, step = self._roll.frame(number), self._payload
        count = -(-len(data) // step)
        packets = []
        for k in range(count):
            kind = 1 if k == 0 else 5 if k == count - 1 else 2
            flag, sequence = self._base + kind, self._sequence
            self._sequence = (self._sequence + 1) % 256
            head = struct.pack("<2sBBBBHI", b"RB", 0, flag, 0, sequence, 0, stamp(number, self._offset))
            packets.append((head + data[k * step : (k + 1) * step], 0))
        return self._spoiled(packets) if number % EVERY == AT else packets

    def _spoiled(self, packets: list[tuple[bytes, int]]) -> list[tuple[bytes, int]]:
        good = packets[SLOT][0]
        if self._fault == "lost":
            packets[SLOT : SLOT + 2] = [(b"", 0)] * 2
        elif self._fault == "burst":
            packets[SLOT : SLOT + 10] = [(b"", 0)] * 10
        elif self._fault == "short":
            packets[SLOT] = (good[: len(good) // 2], 0)
        elif self._fault == "magic":
            packets[SLOT] = (b"XX" + good[2:], 0)
        elif self._fault == "swapped":
            packets[SLOT], packets[SLOT + 1] = packets[SLOT + 1], packets[SLOT]
        elif self._fault == "packet-error":
            packets[SLOT] = (b"", -71)  # EPROTO: what the host notes for a packet that came broken
        return packets
