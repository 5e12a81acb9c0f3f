"""Writing MCAP: chunks of messages with their index, and the summary at the end. mcap.dev/spec. Nothing is packed."""

import struct
from collections import defaultdict
from types import TracebackType
from typing import BinaryIO

from fusion import __version__
from fusion.recording.formats.bags.containers.mcap import (
    CHANNEL,
    CHUNK,
    CHUNK_INDEX,
    FOOTER,
    MESSAGE,
    MESSAGE_INDEX,
    SCHEMA,
    START,
)
from fusion.recording.formats.bags.messages.cdr import definition_text, encoded, long_type
from fusion.recording.formats.bags.messages.values import RosValues

HEADER, DATA_END, STATISTICS = 1, 0x0F, 0x0B
CHUNK_BYTES = 4 << 20  # that of ROS 2's recorder is alike: a few images, so that a reader seeks and keeps little


class McapWriter:
    """A file of messages of ROS 2; to be used as a context, at whose end the summary is written."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._at = 0
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._described: list[bytes] = []  # schemas and channels, said again in the summary
        self._chunk = bytearray()
        self._places: dict[int, list[tuple[int, int]]] = defaultdict(list)  # of the chunk: stamp, offset by channel
        self._indexes: list[bytes] = []
        self._counts: dict[int, int] = defaultdict(int)
        self._stamps: list[int] = []

    def __enter__(self) -> "McapWriter":
        self._put(START)
        self._put(_record(HEADER, _text("ros2") + _text(f"fusion {__version__}")))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None:
            self._end()

    def write(self, topic: str, name: str, stamp: int, values: RosValues) -> None:
        """A message of a built-in type at a stamp [ns]."""
        channel = self._channel(topic, name)
        data = encoded(name, values)
        if self._chunk and len(self._chunk) + len(data) > CHUNK_BYTES:
            self._end_chunk()
        self._places[channel].append((stamp, len(self._chunk)))
        head = struct.pack("<HIQQ", channel, self._counts[channel] & 0xFFFFFFFF, stamp, stamp)
        self._chunk += _record(MESSAGE, head + data)
        self._counts[channel] += 1
        self._stamps.append(stamp)

    def _channel(self, topic: str, name: str) -> int:
        if topic in self._channels:
            return self._channels[topic]
        if name not in self._schemas:
            self._schemas[name] = len(self._schemas) + 1
            text = _text(long_type(name)) + _text("ros2msg") + _text(definition_text(name))
            self._describe(_record(SCHEMA, struct.pack("<H", self._schemas[name]) + text))
        number = self._channels[topic] = len(self._channels) + 1
        about = struct.pack("<HH", number, self._schemas[name]) + _text(topic) + _text("cdr") + struct.pack("<I", 0)
        self._describe(_record(CHANNEL, about))
        return number

    def _describe(self, record: bytes) -> None:
        self._described.append(record)
        self._chunk += record

    def _end_chunk(self) -> None:
        if not self._places:
            return
        stamps = [stamp for places in self._places.values() for stamp, _ in places]
        first, last, size = min(stamps), max(stamps), len(self._chunk)
        start = self._at
        # no check sum: 0 says so
        head = struct.pack("<QQQI", first, last, size, 0) + _text("") + struct.pack("<Q", size)
        self._put(_record(CHUNK, head + bytes(self._chunk)))
        length, offsets, indexes = self._at - start, b"", self._at
        for channel, places in self._places.items():
            offsets += struct.pack("<HQ", channel, self._at)
            entries = b"".join(struct.pack("<QQ", *place) for place in places)
            self._put(_record(MESSAGE_INDEX, struct.pack("<HI", channel, len(entries)) + entries))
        about = struct.pack("<QQQQ", first, last, start, length) + struct.pack("<I", len(offsets)) + offsets
        about += struct.pack("<Q", self._at - indexes) + _text("") + struct.pack("<QQ", size, size)
        self._indexes.append(_record(CHUNK_INDEX, about))
        self._chunk.clear()
        self._places.clear()

    def _end(self) -> None:
        self._end_chunk()
        self._put(_record(DATA_END, struct.pack("<I", 0)))
        summary = self._at
        counts = b"".join(struct.pack("<HQ", *pair) for pair in self._counts.items())
        first, last = (min(self._stamps), max(self._stamps)) if self._stamps else (0, 0)
        about = struct.pack("<QHIIIIQQ", len(self._stamps), len(self._schemas), len(self._channels), 0, 0,
                            len(self._indexes), first, last)  # fmt: skip
        for record in (*self._described, *self._indexes):
            self._put(record)
        self._put(_record(STATISTICS, about + struct.pack("<I", len(counts)) + counts))
        self._put(_record(FOOTER, struct.pack("<QQI", summary, 0, 0)) + START)

    def _put(self, data: bytes) -> None:
        self._file.write(data)
        self._at += len(data)


def _record(kind: int, content: bytes) -> bytes:
    return struct.pack("<BQ", kind, len(content)) + content


def _text(words: str) -> bytes:
    data = words.encode()
    return struct.pack("<I", len(data)) + data
