"""ROS 1 bags, version 2.0: records of a header and data, in chunks. wiki.ros.org/Bags/Format/2.0.

A bag that was cut off has no index at its end: its chunks are then read one by one from the start.
"""

import struct
from collections import defaultdict
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.limits import check_size
from fusion.files.reading import beginning, open_regular
from fusion.recording.formats.bags.containers.packed import Chunk, Chunks, unpack
from fusion.recording.formats.bags.containers.store import MOST_MESSAGES, BagFile, Store, Topic, cut, falls

START = b"#ROSBAG V2.0\n"
MESSAGE, BAG, INDEX, CHUNK, CHUNK_INFO, CONNECTION = 2, 3, 4, 5, 6, 7
LONGEST_HEADER = 1 << 20  # of a record; a connection's holds the text of its type's definition
ENTRY = np.dtype([("sec", "<u4"), ("nsec", "<u4"), ("offset", "<u4")])
# where a message's record lies: chunk (its place in the list), offset in it, time [ns]
PLACE = np.dtype([("chunk", "<i4"), ("offset", "<u4"), ("stamp", "<i8")])


def recognises(path: Path) -> bool:
    """True for a file that begins as a ROS 1 bag does."""
    return beginning(path, len(START)) == START


def read(path: Path) -> Store:
    """The topics of a bag. Raises RecordingError."""
    chunks: list[Chunk] = []
    connections: dict[int, dict[bytes, bytes]] = {}
    places: dict[int, list[NDArray]] = defaultdict(list)
    source = BagFile(path)
    with open_regular(path, RecordingError, "the bag", takes=0) as file:
        size = source.size
        file.seek(len(START))
        total, stopped = 0, False
        for kind, fields, at, length in _records(file, size, path):
            if at + length > size:
                stopped = True
                break
            if kind == CHUNK:
                chunks.append(_chunk(fields, at, length, path))
            elif kind == CONNECTION:
                _connect(connections, fields, file.read(length), path)
                continue
            elif kind == INDEX and chunks:
                total += _entries(places, len(chunks) - 1, fields, file.read(length), path)
                if total > MOST_MESSAGES:
                    raise RecordingError("the bag has too many messages", path, total, f"at most {MOST_MESSAGES}")
                continue
            file.seek(at + length)
        else:
            stopped = file.tell() != size
    kept = Chunks()
    _without_index(source, chunks, places, connections, kept)
    topics: dict[str, Topic] = {}
    joined: dict[bytes, list[int]] = defaultdict(list)
    for number, fields in connections.items():
        joined[fields.get(b"topic", b"")].append(number)
    for name, numbers in joined.items():
        parts = [part for number in numbers for part in places.get(number, [])]
        if parts:
            topics[_text(name)] = _topic(source, _text(name), connections[numbers[0]], parts, chunks, kept)
    warnings = ("the bag was cut off: what was recorded after that is not in it",) if stopped else ()
    return Store(path, topics, warnings)


def _records(file: BinaryIO, size: int, path: Path) -> Iterator[tuple[int, dict[bytes, bytes], int, int]]:
    """Kind, header, where the data begin and how long they are, of each record; the caller moves past the data."""
    while True:
        start = file.tell()
        head = file.read(4)
        if len(head) < 4:
            file.seek(start)
            return
        (length,) = struct.unpack("<I", head)
        if length > LONGEST_HEADER:
            raise cut(path, f"a record's header of {length} bytes at byte {start} of {size}")
        header = file.read(length + 4)
        if len(header) < length + 4:
            file.seek(start)
            return
        fields = _fields(header[:length], path)
        (data,) = struct.unpack("<I", header[length:])
        kind = fields.get(b"op", b"\0")
        yield kind[0] if kind else 0, fields, start + 8 + length, data


def _fields(header: bytes, path: Path) -> dict[bytes, bytes]:
    found, at = {}, 0
    while at + 4 <= len(header):
        (length,) = struct.unpack_from("<I", header, at)
        if at + 4 + length > len(header):
            raise cut(path, "a record's header that leads out of itself")
        name, _, value = header[at + 4 : at + 4 + length].partition(b"=")
        found[name] = value
        at += 4 + length
    return found


def _number(fields: dict[bytes, bytes], name: bytes, path: Path) -> int:
    value = fields.get(name, b"")
    if len(value) != 4:
        raise cut(path, f"a record without {name.decode()}")
    return int.from_bytes(value, "little")


def _chunk(fields: dict[bytes, bytes], at: int, length: int, path: Path) -> Chunk:
    return Chunk(at, length, _text(fields.get(b"compression", b"none")), _number(fields, b"size", path))


def _connect(connections: dict[int, dict[bytes, bytes]], fields: dict[bytes, bytes], data: bytes, path: Path) -> None:
    # old recordings of RealSense name the topic in the data alone (librealsense, issue 7845)
    connections.setdefault(_number(fields, b"conn", path), {**_fields(data, path), **fields})


def _entries(places: dict[int, list[NDArray]], chunk: int, fields: dict[bytes, bytes], data: bytes, path: Path) -> int:
    """Note where the messages of one connection lie in a chunk; returns how many they are."""
    entries = np.frombuffer(data, ENTRY, len(data) // ENTRY.itemsize)
    found = np.empty(len(entries), PLACE)
    found["chunk"], found["offset"] = chunk, entries["offset"]
    found["stamp"] = entries["sec"].astype(np.int64) * 1_000_000_000 + entries["nsec"]
    places[_number(fields, b"conn", path)].append(found)
    return len(entries)


def _without_index(
    source: BagFile,
    chunks: list[Chunk],
    places: dict[int, list[NDArray]],
    connections: dict[int, dict[bytes, bytes]],
    kept: Chunks,
) -> None:
    """Look through chunks that no index tells of: the last one of a bag that was cut off, or all."""
    path = source.path
    told = {int(part["chunk"][0]) for parts in places.values() for part in parts if len(part)}
    for number in sorted(set(range(len(chunks))) - told):
        found: dict[int, list[tuple[int, int, int]]] = defaultdict(list)
        try:
            data = _unpacked(source, chunks[number], kept)
            for offset, fields, begin, length in _inside(data, path):
                kind = fields.get(b"op", b"")
                if kind == bytes([CONNECTION]):
                    _connect(connections, fields, data[begin : begin + length], path)
                elif kind == bytes([MESSAGE]):
                    stamp = fields.get(b"time", b"").ljust(8, b"\0")
                    nanoseconds = int.from_bytes(stamp[:4], "little") * 10**9 + int.from_bytes(stamp[4:8], "little")
                    found[_number(fields, b"conn", path)].append((number, offset, nanoseconds))
        except RecordingError:  # a chunk that is not whole: the others may be
            if len(chunks) == 1:
                raise
        for connection, rows in found.items():
            places[connection].append(np.array(rows, PLACE))


def _inside(data: bytes, path: Path) -> Iterator[tuple[int, dict[bytes, bytes], int, int]]:
    """Offset, header, and data's start and length of each record in a chunk."""
    at = 0
    while at + 8 <= len(data):
        (head,) = struct.unpack_from("<I", data, at)
        if at + 8 + head > len(data):
            raise cut(path, "a message that leads out of its chunk")
        (length,) = struct.unpack_from("<I", data, at + 4 + head)
        begin = at + 8 + head
        if begin + length > len(data):
            raise cut(path, "a message that leads out of its chunk")
        yield at, _fields(data[at + 4 : at + 4 + head], path), begin, length
        at = begin + length


def _topic(
    source: BagFile, name: str, fields: dict[bytes, bytes], parts: list[NDArray], chunks: list[Chunk], kept: Chunks
) -> Topic:
    places = np.concatenate(parts)
    places = places[np.argsort(places["stamp"], kind="stable")]
    return Topic(
        name=name,
        type=_text(fields.get(b"type", b"")),
        stamps=places["stamp"].copy(),
        read=partial(_message, source, chunks, places, kept),
        definition=_text(fields.get(b"message_definition", b"")),
        ros2=False,
        packed=any(chunk.how not in ("", "none") for chunk in chunks),
        steps_back=falls(places["stamp"], places["chunk"], places["offset"]),
    )


def _message(source: BagFile, chunks: list[Chunk], places: NDArray, kept: Chunks, index: int, most: int = -1) -> bytes:
    chunk, offset = chunks[int(places["chunk"][index])], int(places["offset"][index])
    path = source.path
    if chunk.how in ("", "none"):
        most_here = chunk.packed - offset
        (head,) = struct.unpack("<I", source.read(chunk.at + offset, 4))
        if head > LONGEST_HEADER or head + 8 > most_here:
            raise cut(path, "a message that leads out of its chunk")
        length = int.from_bytes(source.read(chunk.at + offset + 4 + head, 4), "little")
        if head + 8 + length > most_here:
            raise cut(path, "a message that leads out of its chunk")
        return source.read(chunk.at + offset + 8 + head, length if most < 0 else min(most, length), "a message")
    data = _unpacked(source, chunk, kept)
    if offset + 4 > len(data):
        raise cut(path, "a message that leads out of its chunk")
    head = int.from_bytes(data[offset : offset + 4], "little")
    length = int.from_bytes(data[offset + 4 + head : offset + 8 + head], "little")
    begin = offset + 8 + head
    if begin + length > len(data):
        raise cut(path, "a message that leads out of its chunk")
    return data[begin : begin + (length if most < 0 else min(most, length))]


def _unpacked(source: BagFile, chunk: Chunk, kept: Chunks) -> bytes:
    data = kept.get(chunk.at)
    if data is None:
        check_size(chunk.size, source.path, RecordingError, "a chunk of the bag")
        data = unpack(source.read(chunk.at, chunk.packed, "a chunk"), chunk.how, chunk.size, source.path)
        kept.put(chunk.at, data)
    return data


def _text(data: bytes) -> str:
    return data.decode("utf-8", "replace")
