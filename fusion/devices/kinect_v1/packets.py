"""Packets of a stream become frames: what is lost, short or out of step is counted, and never passes for a value."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

HEADER = 12  # bytes: "RB", 0, flag, ?, sequence number, ?, ?, time stamp
FIRST, MIDDLE, LAST = 1, 2, 5
MOST_LOST = 5  # packets in a row that may be missing; beyond, the place in the frame is in doubt

Packet = bytes | bytearray


@dataclass(frozen=True)
class StreamFormat:
    """How one kind of frame is sent."""

    name: str  # for a person
    base: int  # upper half of the flag
    payload: int  # bytes of a full packet without its header
    size: int  # bytes of a frame

    @property
    def packets(self) -> int:
        """Packets of a frame."""
        return -(-self.size // self.payload)


DEPTH_11 = StreamFormat("depth", 0x70, 1748, 422_400)
DEPTH_10 = StreamFormat("depth", 0x70, 1748, 384_000)
BAYER = StreamFormat("colour", 0x80, 1908, 307_200)
IR_10 = StreamFormat("infrared", 0x80, 1908, 390_400)


@dataclass
class PacketCounts:
    """What happened on a stream since it began."""

    # that held something; failed, alien, short, long: those the bus failed on, without the magic, with too little
    # (kept) or too much in them (not kept)
    packets: int = 0
    failed: int = 0
    alien: int = 0
    short: int = 0
    long: int = 0
    lost: int = 0  # missing by their number; resyncs: how often the place in the frame was in doubt
    resyncs: int = 0
    frames: int = 0  # handed over; damaged: of these with holes; dropped: begun and given up
    damaged: int = 0
    dropped: int = 0


@dataclass(frozen=True)
class RawFrame:
    """A frame as it was sent."""

    data: bytearray  # its bytes; those in `holes` mean nothing
    ticks: int  # the device's clock, 32 bit, of some 60 MHz
    holes: tuple[tuple[int, int], ...] = ()  # (begin, end) of bytes that did not come


@dataclass
class Assembler:
    """Puts packets together; hands each frame that ends to `done`."""

    format: StreamFormat
    done: Callable[[RawFrame], None]
    counts: PacketCounts = field(default_factory=PacketCounts)
    _data: bytearray = field(default_factory=bytearray)
    _holes: list[tuple[int, int]] = field(default_factory=list)
    _place: int = -1  # of the next packet in its frame; -1: not in step
    _sequence: int = 0
    _ticks: int = 0

    def feed(self, packets: Iterable[tuple[int, Packet]]) -> None:
        """Packets in their order, each with its USB status (0: well)."""
        for status, packet in packets:
            if status:
                self.counts.failed += 1
            elif len(packet) >= HEADER and packet[0] == 0x52 and packet[1] == 0x42:
                self._one(packet)
            elif len(packet):
                self.counts.alien += 1

    def _one(self, packet: Packet) -> None:
        self.counts.packets += 1
        flag, sequence, form = packet[3] - self.format.base, packet[5], self.format
        if self._place < 0:
            if flag != FIRST:
                return
            self._begin()
        elif sequence != self._sequence and not self._skip((sequence - self._sequence) & 0xFF, flag):
            return
        place, last = self._place, form.packets - 1
        if flag != (FIRST if place == 0 else LAST if place == last else MIDDLE):
            self._lose_step(flag)
            if self._place < 0:
                return
            place = self._place
        self._sequence = (sequence + 1) & 0xFF
        begin, length = place * form.payload, len(packet) - HEADER
        due = form.size - begin if place == last else form.payload
        if length > due:
            self.counts.long += 1
            self._holes.append((begin, begin + due))
        else:
            self._data[begin : begin + length] = packet[HEADER:]
            if length < due:
                self.counts.short += 1
                self._holes.append((begin + length, begin + due))
        self._place = place + 1
        if place == 0 or place == last:  # all packets of a frame have the same
            self._ticks = int.from_bytes(packet[8:12], "little")
        if place == last:
            self._end()

    def _begin(self) -> None:
        self._data, self._holes, self._place = bytearray(self.format.size), [], 0

    def _skip(self, lost: int, flag: int) -> bool:
        """Leave the places of packets that are missing; False when the step is lost and this packet begins nothing."""
        self.counts.lost += lost
        if lost > MOST_LOST:
            self._lose_step(flag)
            return self._place == 0
        payload, size = self.format.payload, self.format.size
        for _ in range(lost):
            self._holes.append((self._place * payload, min((self._place + 1) * payload, size)))
            self._place += 1
            if self._place == self.format.packets:  # the frame's last packet is among them
                self._end()
        return True

    def _lose_step(self, flag: int) -> None:
        """What was begun is given up; a first packet begins anew."""
        self.counts.resyncs += 1
        self.counts.dropped += self._place > 0
        self._place = -1
        if flag == FIRST:
            self._begin()

    def _end(self) -> None:
        self.counts.frames += 1
        self.counts.damaged += bool(self._holes)
        frame = RawFrame(self._data, self._ticks, tuple(self._holes))
        self._begin()
        self.done(frame)
