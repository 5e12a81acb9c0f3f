"""LZFSE, as Apple packs depth: the size that the blocks claim is looked at before anything is unpacked."""

import struct
from pathlib import Path

from fusion.errors import RecordingError
from fusion.files.extra import extra

END = b"bvx$"
_V2 = struct.Struct("<4sIQQQ")  # magic, unpacked bytes, three packed fields: lzfse_internal.h


def unpack(data: bytes, size: int, where: Path) -> bytes:
    """`size` bytes out of packed ones; bytes that are as long already are returned as they are.

    Raises:
        RecordingError: they are damaged, or become more or less; the library is not installed.
    """
    if len(data) == size and data[:3] != b"bvx":
        return data
    claimed = _claimed(data)
    if claimed != size:
        found = f"{claimed} bytes" if claimed >= 0 else f"a file that begins with {data[:8]!r}, or is cut off"
        raise RecordingError("an image cannot be unpacked (LZFSE)", where, found, f"{size} bytes, as its size says")
    library = extra("lzfse", "iphone", "a Record3D recording", where, RecordingError)
    try:
        made = bytes(library.decompress(data))
    except (library.error, MemoryError, ValueError) as problem:
        raise RecordingError("an image cannot be unpacked (LZFSE)", where, str(problem)[:60], "whole data") from problem
    if len(made) != size:
        raise RecordingError("an image cannot be unpacked (LZFSE)", where, f"{len(made)} bytes", f"{size} bytes")
    return made


def _claimed(data: bytes) -> int:
    """Bytes that all blocks together say they unpack to; -1 where they are not whole."""
    at, total = 0, 0
    while data[at : at + 4] != END:
        kind = data[at : at + 4]
        if len(data) < at + 12 or kind not in (b"bvx-", b"bvxn", b"bvx2"):
            return -1
        raw, packed = struct.unpack_from("<II", data, at + 4)
        if kind == b"bvx-":
            step = 8 + raw
        elif kind == b"bvxn":
            step = 12 + packed
        else:
            if len(data) < at + _V2.size:
                return -1
            _, raw, first, second, third = _V2.unpack_from(data, at)
            step = (third & 0xFFFFFFFF) + (first >> 20 & 0xFFFFF) + (second >> 40 & 0xFFFFF)
        total, at = total + raw, at + max(step, 8)
    return total
