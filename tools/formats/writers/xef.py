"""Kinect Studio's `.xef`, plain and archived, as KinectXEFTools describes and reads it (kinect_xef_documentation.txt).

No program of the maker runs here, so what the description leaves open is filled with numbers that a reader must not
need. `xef_check.py` has that project's own reader go through the file.
"""

import struct
import uuid
import zlib
from functools import lru_cache
from pathlib import Path

import numpy as np

from tools.formats.take import Array, Take

WIDTH, HEIGHT, FIRST_TICK = 512, 424, 61_234_567
DEPTH, INFRARED, COLOR, BODY = (
    uuid.UUID(one)
    for one in (
        "0a3914d6-3b16-11e1-aac3-001e4fd58c0f",
        "0a3914d7-3b16-11e1-aac3-001e4fd58c0f",
        "2ba0d67d-be11-4534-9444-3fb21ae0f08b",
        "a0c45179-5168-4875-a75c-f8f1760f637c",
    )
)
PROPERTIES = uuid.UUID("8083a32f-d7b4-449b-99b9-44c6fcd97570")
UNKNOWN, SEMANTIC, ARCHIVED_GAP = 0xFFFF, uuid.UUID(int=0x23), 0xC000
# index, name, what it is, bytes of a tag: audio and body have other tags than images in the files that were described
STREAMS = {
    1: ("Nui Body Frame", BODY, 0),
    2: ("Nui Depth", DEPTH, 4),
    3: ("Nui IR", INFRARED, 4),
    4: ("Nui Uncompressed Color", COLOR, 4),
}
Event = tuple[int, int, int, bytes]  # stream, tick, frame, bytes


def write(take: Take, path: Path, archived: bool = False, color: bool = False) -> Path:
    """The recording: depth and infrared mirrored, as Microsoft's SDK shows them; colour costs 4 MB a frame.

    Ticks (100 ns) begin anywhere, as in files that were cut from longer ones.
    """
    streams = [i for i in STREAMS if color or i != 4]
    out = path.with_suffix(".xef")
    with out.open("wb") as file:
        file.write(b"EVENTS1\0" + struct.pack("<IIQ", 5, 0 if archived else len(streams) + 1, 0))
        file.write(described(0, "Properties", PROPERTIES, 24, False) + properties())
        if archived:
            file.write(struct.pack("<HHIQII", UNKNOWN, 0, 1, 0, 0, 0) + bytes(ARCHIVED_GAP))
            for index in streams:
                file.write(described(index, *STREAMS[index], archived=index != 1))
                file.writelines(packed(one, index != 1) for one in events(take, color) if one[0] == index)
        else:
            file.writelines(described(index, *STREAMS[index], archived=False) for index in streams)
            for number, one in enumerate(events(take, color)):
                file.write(packed(one, False))
                # records of an unknown kind, of the lengths that were seen; often several in a row
                file.writelines(
                    unknown(length, one[1]) for length in {2: (0x7000,), 5: (0x6000, 0xC000, 0x7000)}.get(number, ())
                )
            file.write(struct.pack("<H", len(streams) + 1) + b"\xff" * 0x6B0)
            size = file.tell()
            file.seek(16)
            file.write(struct.pack("<Q", size))
    return out


def events(take: Take, color: bool) -> "list[Event]":
    """By their time; infrared comes with its depth, colour a little later. Depth comes again where stamps are more."""
    images = []
    for counts in take.counts(0.001):
        mirrored = np.ascontiguousarray(counts[:, ::-1]).astype("<u2")
        infrared = np.where(mirrored > 0, 800 + mirrored // 8, 0).astype("<u2")
        images.append((mirrored.tobytes(), infrared.tobytes()))
    out: list[Event] = []
    for i, stamp in enumerate(take.stamps):
        tick, frame = FIRST_TICK + round((stamp - take.stamps[0]) * 1e7), 100 + i
        depth, infrared_bytes = images[i % len(images)]
        out += [(2, tick, frame, depth), (3, tick, frame, infrared_bytes), (1, tick + 9_000, 0, bytes(64))]
        if color:
            out.append((4, tick + 60_000, frame, yuy2(take.color, i)))
    return out


@lru_cache(maxsize=16)
def squeezed(held: bytes) -> bytes:
    """By zlib at its fastest, which begins with 78 01, as the files that were described."""
    return zlib.compress(held, 1)


def yuy2(pictures: "np.ndarray | None", i: int) -> bytes:
    """(1080, 1920) pixels of Y, U, Y, V, mirrored; of a take without such a picture a ramp."""
    if pictures is not None and pictures.shape[1:3] == (1080, 1920):
        wide: Array = pictures[i][:, ::-1].astype(float)
    else:
        wide = np.repeat(np.tile(np.linspace(20, 220, 1920), (1080, 1))[..., None], 3, axis=2)
    y = wide @ [0.299, 0.587, 0.114]
    u, v = 128 + 0.564 * (wide[..., 2] - y), 128 + 0.713 * (wide[..., 0] - y)
    both = np.stack([y, np.where(np.arange(1920) % 2, v, u)], axis=-1)
    return np.clip(np.rint(both), 0, 255).astype(np.uint8).tobytes()


def packed(event: Event, archived: bool) -> bytes:
    """Head of 24 bytes, the tag, the bytes."""
    index, tick, frame, held = event
    tag = struct.pack("<I", frame)[: STREAMS[index][2]]
    body = squeezed(held) if archived else held
    return struct.pack("<HHIqII", index, archived, len(body), tick, 7 * frame + index, len(held)) + tag + body


def described(index: int, name: str, kind: uuid.UUID, tag: int, archived: bool) -> bytes:
    """A stream's two events: its name and kind; then its meaning, as a property."""
    key = struct.pack("<HH", index, archived)
    head = struct.pack("<HHIqII", index, archived, 292, 0, 0, 292) + key + kind.bytes_le + bytes(4)
    named = name.encode("utf-16-le").ljust(256, b"\0") + struct.pack("<HHQ", 0x3333, tag, 0) + key
    meaning = struct.pack("<I", 78) + f"{{{SEMANTIC}}}".encode("utf-16-le").ljust(78, b"\0") + SEMANTIC.bytes_le
    extra = b"\x11" * 8 if archived else b""
    return head + named.ljust(292, b"\x22") + extra + a_property(meaning)


def a_property(held: bytes) -> bytes:
    """An event of stream 0: its tag is a GUID and eight more bytes' worth of anything."""
    return struct.pack("<HHIqII", 0, 0, len(held), 0, 0, len(held)) + PROPERTIES.bytes_le + bytes(8) + held


def properties() -> bytes:
    """Of the file as a whole; with them streams begin at 0x4B4, where they were seen."""
    texts = "Kinect Studio", "judge"
    room = (0x4B4 - 0x1FE) // len(texts) - 48
    return b"".join(a_property(text.encode("utf-16-le").ljust(room, b"\0")) for text in texts)


def unknown(length: int, tick: int) -> bytes:
    """A record of which only the head is known."""
    held = bytearray(length)
    held[: 4 * 256] = np.arange(1, 257, dtype="<u4").tobytes()
    return struct.pack("<HHIqII", UNKNOWN, 0, 3, tick, 0, 0) + bytes(held)
