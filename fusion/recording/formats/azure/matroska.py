"""What stands where in a Matroska file (RFC 9559): tracks, attachments, tags and the places of the images.

Heads of elements are read one after the other and data are passed over, so that a file of any length is opened without
its images; a list at its end (Cues), which files that were cut off lack, is not needed.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from fusion.errors import RecordingError
from fusion.files.limits import check_size
from fusion.files.reading import open_regular
from fusion.recording.formats.recorded.parts import ByteRange

START = b"\x1a\x45\xdf\xa3"
# elements by their identifiers
SEGMENT, INFO, SCALE = 0x18538067, 0x1549A966, 0x2AD7B1
TRACKS, TRACK, NUMBER, PRIVATE, NAME, VIDEO, WIDTH, HEIGHT = 0x1654AE6B, 0xAE, 0xD7, 0x63A2, 0x536E, 0xE0, 0xB0, 0xBA
FILES, FILE, FILE_NAME, FILE_DATA = 0x1941A469, 0x61A7, 0x466E, 0x465C
TAGS, TAG, SIMPLE_TAG, TAG_NAME, TAG_TEXT = 0x1254C367, 0x7373, 0x67C8, 0x45A3, 0x4487
CLUSTER, STAMP, GROUP, BLOCK, SIMPLE_BLOCK = 0x1F43B675, 0xE7, 0xA0, 0xA1, 0xA3
HOLDERS = {SEGMENT, INFO, TRACKS, TRACK, VIDEO, FILES, FILE, TAGS, TAG, SIMPLE_TAG, CLUSTER, GROUP}
LACED = 0x06  # of a block's flags: several frames in one
FIELD = 4096  # bytes that a name, a tag or a track's private part may have
TAKES = 300  # bytes in memory for each image's place
NANOSECONDS = 1_000_000  # of a tick, where the file does not say it


@dataclass
class Track:
    """One stream: its name, its codec's four letters, the size of its images, and where they lie."""

    name: str = ""
    codec: str = ""
    width: int = 0
    height: int = 0
    ticks: list[int] = field(default_factory=list)
    parts: list[ByteRange] = field(default_factory=list)

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) [px]."""
        return self.width, self.height


@dataclass
class Matroska:
    """What a file holds."""

    tracks: dict[int, Track] = field(default_factory=dict)  # by number
    files: dict[str, ByteRange] = field(default_factory=dict)  # attachments by name: where their data lie
    tags: dict[str, str] = field(default_factory=dict)  # by name
    scale: int = NANOSECONDS  # nanoseconds of a tick
    whole: bool = True  # False for a file that was cut off


@dataclass(frozen=True)
class MatroskaElement:
    """The head of one: its identifier, where its data begin, and how many bytes these are."""

    kind: int
    begin: int
    size: int


def read_matroska(path: Path, heads_only: bool = False) -> Matroska:
    """What a file holds, `heads_only` what stands before its first image. Raises RecordingError."""
    out, reader = Matroska(), None
    with open_regular(path, RecordingError, "the recording", takes=0) as file:
        reader = _ElementReader(file, path, out)
        for element in _elements(file, out):
            if heads_only and element.kind == CLUSTER:
                break
            reader.take(element)
    return out


class _ElementReader:
    """Takes elements in their order: what belongs together stands together."""

    def __init__(self, file: BinaryIO, path: Path, out: Matroska) -> None:
        self._file, self._path, self._out = file, path, out
        self._track, self._name, self._tag, self._cluster, self._images = Track(), "", "", 0, 0

    def take(self, element: MatroskaElement) -> None:
        """Note what an element says."""
        kind = element.kind
        if kind == TRACK:
            self._track = Track()
        elif kind in (BLOCK, SIMPLE_BLOCK):
            self._image(element)
        elif kind == STAMP:
            self._cluster = self._integer(element)
        elif kind == SCALE:
            self._out.scale = self._integer(element)
        elif kind in (NUMBER, NAME, PRIVATE, WIDTH, HEIGHT):
            self._of_track(element)
        elif kind == FILE_NAME:
            self._name = self._text(element)
        elif kind == FILE_DATA:
            self._out.files[self._name] = ByteRange(element.begin, element.size)
        elif kind == TAG_NAME:
            self._tag = self._text(element)
        elif kind == TAG_TEXT:
            self._out.tags.setdefault(self._tag, self._text(element))

    def _of_track(self, element: MatroskaElement) -> None:
        if element.kind == NUMBER:
            self._out.tracks[self._integer(element)] = self._track
        elif element.kind == NAME:
            self._track.name = self._text(element)
        elif element.kind == PRIVATE:
            # of Video for Windows: BITMAPINFOHEADER, whose fifth number is the codec
            self._track.codec = self._bytes(element)[16:20].decode("ascii", "replace")
        elif element.kind == WIDTH:
            self._track.width = self._integer(element)
        else:
            self._track.height = self._integer(element)

    def _image(self, element: MatroskaElement) -> None:
        self._file.seek(element.begin)
        head = self._file.read(12)
        number, used = _number(head, keep_mark=False)
        track = self._out.tracks.get(number)
        if track is None or len(head) < used + 3 or element.size <= used + 3:
            return
        late, flags = struct.unpack(">hB", head[used : used + 3])
        if flags & LACED:
            raise RecordingError("several images stand in one block", self._path, "lacing", "a block for each image")
        self._images += 1
        check_size(TAKES * self._images, self._path, RecordingError, "the list of images")
        track.ticks.append(self._cluster + late)
        track.parts.append(ByteRange(element.begin + used + 3, element.size - used - 3))

    def _bytes(self, element: MatroskaElement) -> bytes:
        self._file.seek(element.begin)
        return self._file.read(min(element.size, FIELD))

    def _integer(self, element: MatroskaElement) -> int:
        return int.from_bytes(self._bytes(element)[:8], "big")

    def _text(self, element: MatroskaElement) -> str:
        return self._bytes(element).rstrip(b"\0").decode("utf-8", "replace")


def _elements(file: BinaryIO, out: Matroska) -> Iterator[MatroskaElement]:
    """Every element in its order, those that hold others before these; ends where the file was cut off."""
    size = file.seek(0, 2)
    at = 0
    while at < size:
        file.seek(at)
        head = file.read(12)
        kind, first = _number(head, keep_mark=True)
        length, second = _number(head[first:], keep_mark=False)
        begin = at + first + second
        # a size of ones only is one that was not known when it was written
        unknown = second > 0 and length == (1 << 7 * second) - 1
        if not (first and second) or (kind not in HOLDERS and (unknown or begin + length > size)):
            out.whole = False
            return
        if kind == SEGMENT and not unknown and begin + length > size:
            out.whole = False
        yield MatroskaElement(kind, begin, length)
        at = begin if kind in HOLDERS else begin + length


def _number(data: bytes, keep_mark: bool) -> tuple[int, int]:
    """An EBML number (RFC 8794, 4) and its bytes, 0 where there is none; identifiers keep the mark of their length."""
    used = 9 - data[0].bit_length() if data and data[0] else 0
    if not used or len(data) < used:
        return 0, 0
    value = int.from_bytes(data[:used], "big")
    return (value if keep_mark else value & ((1 << 7 * used) - 1)), used
