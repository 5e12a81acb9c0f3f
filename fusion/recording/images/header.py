"""What the header of an image file promises, looked at before anything is decoded or allocated."""

import io
import re
import struct
import zlib
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

PNG_START = b"\x89PNG\r\n\x1a\n"
JPEG_START = b"\xff\xd8\xff"
OTHERS = {b"BM": "BMP", b"II*\0": "TIFF", b"MM\0*": "TIFF"}
MODES = {"I;16": (1, 2), "I;16B": (1, 2), "F": (1, 4), "L": (1, 1)}  # Pillow's names: channels, bytes
PNM = re.compile(rb"P([56])\s+(?:#[^\n]*\n\s*)*([0-9]{1,5})\s+([0-9]{1,5})\s+([0-9]{1,5})\s")  # PGM and PPM
# colour type: (channels, bits that a channel may have)
_PNG_KINDS = {0: (1, (1, 2, 4, 8, 16)), 2: (3, (8, 16)), 3: (3, (1, 2, 4, 8)), 4: (2, (8, 16)), 6: (4, (8, 16))}
_PNG_NEEDED = (b"IHDR", b"PLTE", b"tRNS", b"IDAT", b"IEND")
_JPEG_FRAMES = {0xC0, 0xC1, 0xC2, 0xC3, 0xC5, 0xC6, 0xC7, 0xC9, 0xCA, 0xCB, 0xCD, 0xCE, 0xCF}
ORIENTATION = 274
_JPEG_BARE = {0x01, *range(0xD0, 0xD8)}  # markers without a length


@dataclass(frozen=True)
class ImageHeader:
    """Size [px], channels and bytes of each as they are decoded."""

    width: int
    height: int
    channels: int
    depth: int

    @property
    def size(self) -> int:
        """Of the decoded image [bytes]."""
        return self.width * self.height * self.channels * self.depth


def read_header(data: bytes) -> ImageHeader:
    """The header of a PNG or JPEG, or of a BMP, TIFF, PGM or PPM.

    Raises:
        ValueError: what is wrong with it, or that it is none of these.
    """
    if data.startswith(PNG_START):
        return _png(data)
    if data.startswith(JPEG_START):
        return _jpeg(data)
    if plain := PNM.match(data):
        six, width, height, most = (int(word) for word in plain.groups())
        return ImageHeader(width, height, 3 if six == 6 else 1, 2 if most > 255 else 1)
    kind = next((name for start, name in OTHERS.items() if data.startswith(start)), None)
    if kind is None:
        raise ValueError(f"a file that begins with {data[:8]!r}" if data else "an empty file")
    return _other(data, kind)


def exif_turn(data: bytes) -> int:
    """Quarter turns against the clock, 0 to 3, that the notes of a photograph ask for; 0 for none, or a mirror.

    EXIF 2.32, tag 274 (orientation): 3 half round, 6 to the right, 8 to the left.
    """
    from PIL import Image

    try:
        with Image.open(io.BytesIO(data)) as image:
            asked = image.getexif().get(ORIENTATION)
    except Exception:  # whatever it meets in broken notes
        return 0
    return {3: 2, 6: 3, 8: 1}.get(asked, 0) if isinstance(asked, int) else 0


def plain_png(data: bytes) -> bytes:
    """A PNG with nothing but what its pixels need: of the rest libpng complains on the terminal.

    Raises:
        ValueError: where it is cut off, or a check sum is wrong.
    """
    parts, at, spare = [0, len(PNG_START)], len(PNG_START), False
    while at + 12 <= len(data):
        (length,) = struct.unpack_from(">I", data, at)
        end = at + 12 + length
        if end > len(data):
            break
        kind = data[at + 4 : at + 8]
        if zlib.crc32(memoryview(data)[at + 4 : end - 4]) != struct.unpack_from(">I", data, end - 4)[0]:
            raise ValueError(f"a wrong check sum at byte {at}")
        if kind in _PNG_NEEDED:
            parts += [at, end]
        else:
            spare = True
            if not kind[0] & 32:  # a capital: whoever does not know it cannot read the image
                raise ValueError(f"an unknown part {kind!r}")
        at = end
        if kind == b"IEND":
            if not spare:
                return data
            return b"".join(data[begin:end] for begin, end in list(pairwise(parts))[::2])
    raise ValueError(f"a file cut off after {len(data)} bytes")


def whole_pnm(data: bytes, header: ImageHeader) -> bytes:
    """A PGM or PPM as it is; ValueError where it has fewer bytes than its pixels need."""
    begin = PNM.match(data)
    there = len(data) - (begin.end() if begin else 0)
    if not 0 < header.size <= there:
        raise ValueError(f"{there} of {header.size} bytes")
    return data


def _png(data: bytes) -> ImageHeader:
    if len(data) < 33 or data[12:16] != b"IHDR":
        raise ValueError(f"a file cut off after {len(data)} bytes")
    width, height, bits, kind, packing, filters, interlaced = struct.unpack(">IIBBBBB", data[16:29])
    channels, allowed = _PNG_KINDS.get(kind, (0, ()))
    if not 0 < min(width, height) <= max(width, height) < 1 << 31 or bits not in allowed:
        raise ValueError(f"a PNG header of {width} x {height}, {bits} bit, kind {kind}")
    if packing or filters or interlaced > 1:
        raise ValueError("a PNG header that nobody knows")
    return ImageHeader(width, height, channels, 2 if bits == 16 else 1)


def _jpeg(data: bytes) -> ImageHeader:
    at = 2
    while at + 4 <= len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if marker == 0xFF:
            at += 1
            continue
        if marker in _JPEG_BARE:
            at += 2
            continue
        (length,) = struct.unpack_from(">H", data, at + 2)
        if marker in _JPEG_FRAMES and at + 10 <= len(data):
            bits, height, width, channels = struct.unpack_from(">BHHB", data, at + 4)
            if not width or not height or channels not in (1, 3, 4) or bits != 8:
                raise ValueError(f"a JPEG header of {width} x {height}, {bits} bit, {channels} channels")
            return ImageHeader(width, height, 3, 1)
        if marker in (0xD9, 0xDA) or length < 2:
            break
        at += 2 + length
    raise ValueError("a JPEG without a size")


def _other(data: bytes, kind: str) -> ImageHeader:
    from PIL import Image

    try:
        with Image.open(io.BytesIO(data), formats=(kind,)) as image:
            (width, height), (channels, depth) = image.size, MODES.get(image.mode, (4, 2))  # no more than this
    except Image.DecompressionBombError as error:
        raise ValueError(str(error)) from error
    except Exception as error:  # whatever it meets in a broken header
        raise ValueError(f"a {kind} header that cannot be read") from error
    return ImageHeader(width, height, channels, depth)


def tiff_values(data: bytes) -> NDArray:
    """(height, width) or (height, width, channels) values of a TIFF as they are stored.

    Raises:
        ValueError: they cannot be read.
    """
    from PIL import Image

    try:
        with Image.open(io.BytesIO(data), formats=("TIFF",)) as image:
            values = np.asarray(image)
            return values.astype(values.dtype.newbyteorder("="))
    except Exception as error:  # whatever it meets in a broken file
        raise ValueError("a TIFF that cannot be read") from error
