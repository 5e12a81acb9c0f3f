"""PNG files by the format's definition, chunk by chunk, so that each part of one can be made wrong."""

import struct
import zlib

import numpy as np

SIGNATURE = b"\x89PNG\r\n\x1a\n"
CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}  # by colour type


def chunk(kind: bytes, content: bytes, crc: int | None = None) -> bytes:
    """One chunk with its check sum, or a wrong one."""
    right = zlib.crc32(kind + content)
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", right if crc is None else crc)


def header(width: int, height: int, bits: int = 16, kind: int = 0, interlaced: int = 0) -> bytes:
    """The chunk IHDR."""
    return chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, kind, 0, 0, interlaced))


def rows(counts: np.ndarray) -> bytes:
    """Rows (v, u) or (v, u, channels) of uint8 or uint16 without filter, not yet compressed."""
    flat = counts.reshape(counts.shape[0], -1)
    return b"".join(b"\0" + row.astype(">u2" if counts.dtype.itemsize == 2 else "u1").tobytes() for row in flat)


def png(counts: np.ndarray, kind: int = 0, before: bytes = b"", after: bytes = b"") -> bytes:
    """A whole file; `before` and `after` are chunks about the image's data."""
    bits = counts.dtype.itemsize * 8
    data = chunk(b"IDAT", zlib.compress(rows(counts)))
    return (
        SIGNATURE + header(counts.shape[1], counts.shape[0], bits, kind) + before + data + after + chunk(b"IEND", b"")
    )


def claimed(width: int, height: int, bits: int = 16, kind: int = 0, data: bytes = b"") -> bytes:
    """A header that claims a size, and whatever data."""
    return SIGNATURE + header(width, height, bits, kind) + chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b"")


def whole(width: int, height: int, bits: int = 16, kind: int = 0) -> bytes:
    """A true image of zeros of any size: a few kB that unpack to gigabytes."""
    packer, row = zlib.compressobj(9), b"\0" * (1 + width * CHANNELS[kind] * bits // 8)
    parts = [packer.compress(row * 64) for _ in range(height // 64)] + [
        packer.compress(row * (height % 64)),
        packer.flush(),
    ]
    return SIGNATURE + header(width, height, bits, kind) + chunk(b"IDAT", b"".join(parts)) + chunk(b"IEND", b"")


def interlaced(counts: np.ndarray) -> bytes:
    """Adam7, as the definition gives its seven passes."""
    passes = [(0, 0, 8, 8), (0, 4, 8, 8), (4, 0, 8, 4), (0, 2, 4, 4), (2, 0, 4, 2), (0, 1, 2, 2), (1, 0, 2, 1)]
    data = b"".join(rows(counts[v::dv, u::du]) for v, u, dv, du in passes if counts[v::dv, u::du].size)
    head = header(counts.shape[1], counts.shape[0], counts.dtype.itemsize * 8, 0, 1)
    return SIGNATURE + head + chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b"")


def packed(width: int, height: int, bits: int, kind: int, palette: bytes = b"") -> bytes:
    """An image of zeros of any kind: 1 to 16 bits, grey, colour, palette, with alpha."""
    row = b"\0" * (1 + (width * CHANNELS[kind] * bits + 7) // 8)
    data = chunk(b"IDAT", zlib.compress(row * height))
    return SIGNATURE + header(width, height, bits, kind) + palette + data + chunk(b"IEND", b"")


def with_right_sums(content: bytes) -> bytes:
    """The chunks of a PNG with their check sums made right, so that damage gets as far as the decoder."""
    parts, at = [content[:8]], 8
    while at + 12 <= len(content):
        length = int.from_bytes(content[at : at + 4], "big")
        if at + 12 + length > len(content):
            break
        parts.append(chunk(content[at + 4 : at + 8], content[at + 8 : at + 8 + length]))
        at += 12 + length
    return b"".join([*parts, content[at:]])
