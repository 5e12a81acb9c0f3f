"""MCAP files: records in chunks, with a summary at the end. mcap.dev/spec.

Without a summary (a recorder that was stopped) the file is walked through from its start.
"""

import struct
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.reading import beginning, open_regular
from fusion.recording.formats.bags.containers.packed import Chunk, Chunks, unpack
from fusion.recording.formats.bags.containers.store import MOST_MESSAGES, BagFile, Store, Topic, cut, falls, short_type

START = b"\x89MCAP0\r\n"
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = 2, 3, 4, 5, 6, 7, 8
LONGEST = 1 << 26  # of a record that is neither a chunk nor a message
HEAD = 22  # bytes of a message's record before its data: channel, sequence, two stamps
# where a message's record lies: its chunk (-1: none), offset in it or in the file, and stamp [ns]
PLACE = np.dtype([("chunk", "<i4"), ("offset", "<i8"), ("stamp", "<i8")])
ENTRY = np.dtype([("stamp", "<i8"), ("offset", "<i8")])


@dataclass
class _Found:
    """What a walk through the records has found so far."""

    schemas: dict[int, tuple[str, str, str]] = field(default_factory=dict)  # name, encoding, definition
    channels: dict[int, tuple[int, str, str]] = field(default_factory=dict)  # schema, topic, encoding of messages
    chunks: list[Chunk] = field(default_factory=list)
    places: dict[int, list[NDArray]] = field(default_factory=lambda: defaultdict(list))
    count: int = 0


def recognises(path: Path) -> bool:
    """True for a file that begins as MCAP does."""
    return beginning(path, len(START)) == START


def read(path: Path) -> Store:
    """The topics of a file. Raises RecordingError."""
    kept, source = Chunks(), BagFile(path)
    try:
        found, ended = _by_summary(source)
    except (RecordingError, struct.error):  # a summary that leads nowhere: what the file holds is looked at
        found, ended = None, False
    if found is None:
        found = _by_walk(source, kept)
    warnings = () if ended else ("the file has no whole end: it was cut off, or its recorder was stopped",)
    topics: dict[str, Topic] = {}
    names: dict[str, list[int]] = defaultdict(list)
    for number, (schema, name, encoding) in found.channels.items():
        if found.places.get(number) and encoding in ("cdr", "ros1") and schema in found.schemas:
            names[name].append(number)
    for name, numbers in names.items():
        places = np.concatenate([part for number in numbers for part in found.places[number]])
        places = places[np.argsort(places["stamp"], kind="stable")]
        begins = np.array([chunk.at for chunk in found.chunks])
        schema, _, encoding = found.channels[numbers[0]]
        kind, how, definition = found.schemas[schema]
        topics[name] = Topic(
            name,
            short_type(kind),
            places["stamp"].copy(),
            partial(_message, source, found.chunks, places, kept),
            definition if how in ("ros1msg", "ros2msg") else "",
            encoding == "cdr",
            any(chunk.how for chunk in found.chunks),
            falls(places["stamp"], begins[places["chunk"]], places["offset"]),
        )
    return Store(path, topics, warnings)


def _by_summary(source: BagFile) -> tuple[_Found | None, bool]:
    """What the summary at the end says, None where it has no index of the messages; and whether the file is whole."""
    path, size = source.path, source.size
    tail = source.read(max(0, size - 37), min(37, size))
    if len(tail) < 37 or not tail.endswith(START) or tail[0] != FOOTER:
        return None, False
    (summary,) = struct.unpack_from("<Q", tail, 9)
    if not len(START) <= summary < size - 37:
        return None, True
    found = _Found()
    indexed: list[tuple[int, dict[int, int]]] = []
    for kind, data in _records(source.read(summary, size - 37 - summary, "the summary"), path):
        if kind == CHUNK_INDEX:
            indexed.append(_chunk_index(found, data, path))
        else:
            _describe(found, kind, data, path)
    if not indexed or any(not offsets for _, offsets in indexed):
        return None, True
    for number, (length, offsets) in enumerate(indexed):
        begin = min(offsets.values())
        block = source.read(begin, length, "an index of messages")
        for kind, data in _records(block, path):
            if kind == MESSAGE_INDEX:
                _entries(found, number, data, path)
    return found, True


def _chunk_index(found: _Found, data: bytes, path: Path) -> tuple[int, dict[int, int]]:
    """Note a chunk; returns the length of the indexes behind it and where that of each channel begins."""
    _, _, start, length, spread = struct.unpack_from("<QQQQI", data)
    offsets = dict(struct.iter_unpack("<HQ", data[36 : 36 + spread // 10 * 10]))
    at = 36 + spread
    (indexes, named) = struct.unpack_from("<QI", data, at)
    how = data[at + 12 : at + 12 + named].decode("ascii", "replace")
    packed, size = struct.unpack_from("<QQ", data, at + 12 + named)
    # a chunk's records begin behind its own head: opcode, length, two stamps, size, check sum, packing, length
    begin = start + 9 + 8 + 8 + 8 + 4 + 4 + named + 8
    if begin + packed > start + length:
        raise cut(path, "a chunk that is larger than its place")
    found.chunks.append(Chunk(begin, packed, how, size))
    return indexes, offsets


def _entries(found: _Found, chunk: int, data: bytes, path: Path) -> None:
    channel, length = struct.unpack_from("<HI", data)
    entries = np.frombuffer(data[6 : 6 + length], ENTRY, min(length, len(data) - 6) // ENTRY.itemsize)
    _count(found, len(entries), path)
    places = np.empty(len(entries), PLACE)
    places["chunk"], places["offset"], places["stamp"] = chunk, entries["offset"], entries["stamp"]
    if len(places):
        found.places[channel].append(places)


def _count(found: _Found, more: int, path: Path) -> None:
    found.count += more
    if found.count > MOST_MESSAGES:
        raise RecordingError("the bag has too many messages", path, found.count, f"at most {MOST_MESSAGES}")


def _describe(found: _Found, kind: int, data: bytes, path: Path) -> None:
    """Note a schema or a channel."""
    if kind == SCHEMA:
        (number,) = struct.unpack_from("<H", data)
        name, at = _string(data, 2, path)
        how, at = _string(data, at, path)
        text, _ = _string(data, at, path)
        found.schemas[number] = (name, how, text)
    elif kind == CHANNEL:
        number, schema = struct.unpack_from("<HH", data)
        name, at = _string(data, 4, path)
        encoding, _ = _string(data, at, path)
        found.channels[number] = (schema, name, encoding)


def _by_walk(source: BagFile, kept: Chunks) -> _Found:
    """All records from the start, as far as they are whole."""
    found, rows, path, size = _Found(), defaultdict(list), source.path, source.size
    with open_regular(path, RecordingError, "the bag", takes=0) as file:
        at = len(START)
        while at + 9 <= size:
            file.seek(at)
            kind, length = struct.unpack("<BQ", file.read(9))
            if at + 9 + length > size:
                break
            if kind == MESSAGE and length >= HEAD:
                channel, _, stamp = struct.unpack("<HIQ", file.read(14))
                rows[channel].append((-1, at, stamp & (2**63 - 1)))
                _count(found, 1, path)
            elif kind == CHUNK:
                _walk_chunk(found, rows, source.read(at + 9, min(length, 64)), at + 9, length, source, kept)
            elif kind in (SCHEMA, CHANNEL) and length < LONGEST:
                _guarded(found, kind, file.read(length), path)
            at += 9 + length
    for channel, one in rows.items():
        found.places[channel].append(np.array(one, PLACE))
    return found


def _walk_chunk(
    found: _Found, rows: dict[int, list], head: bytes, at: int, length: int, source: BagFile, kept: Chunks
) -> None:
    path = source.path
    _, _, size, _, named = struct.unpack_from("<QQQII", head.ljust(40, b"\0"))
    if 40 + named > min(length, len(head)):
        raise cut(path, f"a chunk at byte {at}")
    how = head[32 : 32 + named].decode("ascii", "replace")
    (packed,) = struct.unpack_from("<Q", head, 32 + named)
    chunk = Chunk(at + 40 + named, packed, how, size)
    found.chunks.append(chunk)
    data = _unpacked(source, chunk, kept)
    place = 0
    for kind, record in _records(data, path):
        if kind == MESSAGE and len(record) >= HEAD:
            channel, _, stamp = struct.unpack_from("<HIQ", record)
            rows[channel].append((len(found.chunks) - 1, place, stamp & (2**63 - 1)))
            _count(found, 1, path)
        else:
            _guarded(found, kind, record, path)
        place += 9 + len(record)


def _guarded(found: _Found, kind: int, data: bytes, path: Path) -> None:
    try:
        _describe(found, kind, data, path)
    except struct.error as problem:
        raise cut(path, "a record that is too short") from problem


def _records(data: bytes, path: Path) -> Iterator[tuple[int, bytes]]:
    """Kind and content of each record; content that cannot be taken apart is the file's fault."""
    at, view = 0, memoryview(data)
    while at + 9 <= len(data):
        kind, length = struct.unpack_from("<BQ", data, at)
        if at + 9 + length > len(data):
            raise cut(path, "a record that leads out of its place")
        yield kind, bytes(view[at + 9 : at + 9 + length])
        at += 9 + length


def _string(data: bytes, at: int, path: Path) -> tuple[str, int]:
    (length,) = struct.unpack_from("<I", data, at)
    if at + 4 + length > len(data):
        raise cut(path, "a text that leads out of its record")
    return data[at + 4 : at + 4 + length].decode("utf-8", "replace"), at + 4 + length


def _message(source: BagFile, chunks: list[Chunk], places: NDArray, kept: Chunks, index: int, most: int = -1) -> bytes:
    number, offset = int(places["chunk"][index]), int(places["offset"][index])
    path = source.path
    if number >= 0 and chunks[number].how:
        data = _unpacked(source, chunks[number], kept)
        head = data[offset : offset + 9]
        length = int.from_bytes(head[1:], "little") - HEAD
        begin = offset + 9 + HEAD
        if len(head) < 9 or length < 0 or begin + length > len(data):
            raise cut(path, "a message that leads out of its chunk")
        return data[begin : begin + (length if most < 0 else min(most, length))]
    at = offset if number < 0 else chunks[number].at + offset
    length = int.from_bytes(source.read(at, 9)[1:], "little") - HEAD
    if length < 0 or (number >= 0 and offset + 9 + HEAD + length > chunks[number].packed):
        raise cut(path, "a message that leads out of its chunk")
    return source.read(at + 9 + HEAD, length if most < 0 else min(most, length), "a message")


def _unpacked(source: BagFile, chunk: Chunk, kept: Chunks) -> bytes:
    data = kept.get(chunk.at)
    if data is None:
        data = unpack(source.read(chunk.at, chunk.packed, "a chunk"), chunk.how, chunk.size, source.path)
        kept.put(chunk.at, data)
    return data
