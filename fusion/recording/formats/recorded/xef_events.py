"""The container of Kinect Studio's `.xef`: which streams there are, and where the images of each lie.

The maker publishes no layout; this is the one of KinectXEFTools' own description (`kinect_xef_documentation.txt` and
`XEFEventReader.cs` of github.com/Isaac-W/KinectXEFTools, tried there by `tools/formats`). Records of unknown
content carry no length: that description tries three; here one is believed only where something whole follows it.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO
from uuid import UUID

from fusion.errors import RecordingError
from fusion.files.reading import open_regular
from fusion.recording.formats.recorded.parts import ByteRange

BEGINNING = b"EVENTS1\0"
START = struct.Struct("<8sIIQ")  # the beginning, a version, streams and one more (0: not said), bytes of data
HEAD = struct.Struct("<HHIqII")  # stream, packed, bytes behind the tag, ticks, unknown, bytes when unpacked
TAG = struct.Struct("<HH16sI")  # of a description: stream, packed, type of its data, nothing
NAMED = struct.Struct("<256sHH")  # of a description: name, unknown, bytes of the tags of this stream
DESCRIPTION = 292  # bytes of a description behind its tag
UNSAID = 8  # bytes behind a description of packed data that no length counts
FILLER = 0xFFFF  # the stream of records of unknown content
FILLED = (0x6000, 0x7000, 0xC000)  # bytes that these have been seen to have


@dataclass
class XefStream:
    """One stream of a file."""

    kind: UUID  # type of its data
    packed: bool  # its data are packed by zlib
    tag: int  # bytes between the head of an event and its data
    ticks: list[int] = field(default_factory=list)  # of its events, 100 ns each, in the file's order
    # the first four bytes of each event's tag; of images the device's number of the frame
    numbers: list[int] = field(default_factory=list)
    parts: list[ByteRange] = field(default_factory=list)  # where the data of each event lie


@dataclass
class Events:
    """What a file holds."""

    streams: dict[int, XefStream] = field(default_factory=dict)  # by their number
    broken: int | None = None  # where reading stopped before the file's end [bytes]; None where it was read to its end

    def of(self, kind: UUID) -> XefStream | None:
        """The stream of this type; None where there is none."""
        return next((stream for stream in self.streams.values() if stream.kind == kind), None)


def events_of(path: Path, kept: dict[UUID, int]) -> Events:
    """Every event of a file, without its data.

    Args:
        path: the file.
        kept: types of data whose events are kept, with the bytes of each when unpacked; others are passed over.

    Raises:
        RecordingError: the file cannot be read.
    """
    with open_regular(path, RecordingError, "the recording", takes=0) as file:
        return _Walk(file, kept).events()


class _Walk:
    """From event to event of an open file."""

    def __init__(self, file: BinaryIO, kept: dict[UUID, int]) -> None:
        self.file, self.kept = file, kept
        self.size = file.seek(0, 2)
        self.found = Events()
        _, _, self.end, _ = START.unpack(self._bytes(0, START.size).ljust(START.size, b"\0"))
        self.at = START.size

    def events(self) -> Events:
        """All of them, as far as they are whole."""
        while self.at < self.size and not self._ended(self.at):
            step = self._step(self.at)
            if step is None:
                self.found.broken = self.at
                break
            self.at = step
        return self.found

    def _bytes(self, at: int, count: int) -> bytes:
        self.file.seek(at)
        return self.file.read(count)

    def _ended(self, at: int) -> bool:
        mark = self._bytes(at, 2)
        return self.end > 0 and len(mark) == 2 and int.from_bytes(mark, "little") == self.end

    def _step(self, at: int) -> int | None:
        """Where the next event begins, this one kept; None where nothing whole is here."""
        head = self._bytes(at, HEAD.size)
        if len(head) < HEAD.size:
            return None
        number, _, size, ticks, _, _ = HEAD.unpack(head)
        if number == FILLER:
            return next((there for there in self._behind(at) if self._whole(there)), None)
        if not self._whole(at):
            return None
        if number not in self.found.streams:
            return self._described(at, number, size)
        stream = self.found.streams[number]
        begin = at + HEAD.size + stream.tag
        if stream.kind in self.kept:
            stream.ticks.append(ticks)
            stream.numbers.append(int.from_bytes(self._bytes(at + HEAD.size, min(4, stream.tag)), "little"))
            stream.parts.append(ByteRange(begin, size))
        return begin + size

    def _behind(self, at: int) -> Iterator[int]:
        return (at + HEAD.size + length for length in FILLED)

    def _image(self, stream: XefStream, size: int, unpacked: int) -> bool:
        return (unpacked if stream.packed else size) == self.kept[stream.kind]

    def _whole(self, at: int) -> bool:
        """True where an event, another record of unknown content or the end stands at a place."""
        if at == self.size or self._ended(at):
            return True
        head = self._bytes(at, HEAD.size)
        if len(head) < HEAD.size:
            return False
        number, packed, size, ticks, nothing, unpacked = HEAD.unpack(head)
        if number == FILLER:  # where others have their size it has a number of unknown meaning
            return packed == nothing == unpacked == 0
        if size == 0 or ticks < 0 or packed > 1 or (self.end and number >= self.end):
            return False
        stream = self.found.streams.get(number)
        if stream is None:
            tag = self._bytes(at + HEAD.size, TAG.size)
            return size == DESCRIPTION and len(tag) == TAG.size and TAG.unpack(tag)[0] == number
        fits = stream.kind not in self.kept or self._image(stream, size, unpacked)
        return fits and at + HEAD.size + stream.tag + size <= self.size

    def _described(self, at: int, number: int, size: int) -> int | None:
        """A stream's description, and the property behind it: where the next event begins."""
        tag = at + HEAD.size
        said = self._bytes(tag + TAG.size, NAMED.size)
        if len(said) < NAMED.size:
            return None
        _, packed, kind, _ = TAG.unpack(self._bytes(tag, TAG.size))
        stream = XefStream(UUID(bytes_le=kind), bool(packed & 1), NAMED.unpack(said)[2])
        behind = tag + TAG.size + size + (UNSAID if stream.packed else 0)
        head = self._bytes(behind, HEAD.size)
        if len(head) < HEAD.size:
            return None
        self.found.streams[number] = stream
        return behind + HEAD.size + TAG.size + HEAD.unpack(head)[2]
