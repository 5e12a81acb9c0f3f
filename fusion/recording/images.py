"""Single images of a recording: whole files only, as arrays, with errors that name the file."""

import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError

PNG_START = b"\x89PNG\r\n\x1a\n"
JPEG_START = b"\xff\xd8\xff"


def read_counts(path: Path) -> NDArray[np.uint16]:
    """(height, width) counts of a 16-bit grey image. Raises RecordingError."""
    image = _decode(path, cv2.IMREAD_UNCHANGED)
    if image.dtype != np.uint16 or image.ndim != 2:
        channels = 1 if image.ndim == 2 else image.shape[2]
        found = f"{8 * image.dtype.itemsize} bit, {channels} channel(s)"
        raise RecordingError("the image is not a 16-bit grey image", path, found, "16-bit PNG with one channel")
    return image


def read_color(path: Path) -> NDArray[np.uint8]:
    """(height, width, 3) RGB of an 8-bit image; grey is repeated. Raises RecordingError."""
    return np.ascontiguousarray(_decode(path, cv2.IMREAD_COLOR)[..., ::-1])


def read_ir(path: Path) -> NDArray[np.uint16]:
    """(height, width) counts of a grey image of 8 or 16 bit. Raises RecordingError."""
    image = _decode(path, cv2.IMREAD_UNCHANGED)
    if image.ndim != 2:
        raise RecordingError("the IR image is not grey", path, f"{image.shape[2]} channels", "one channel")
    return image.astype(np.uint16)


def read_mask(path: Path) -> NDArray[np.bool_]:
    """(height, width) True where a PNG is not zero, or opaque if it has transparency. Raises RecordingError."""
    start = read_bytes(path, len(PNG_START))
    if start != PNG_START:  # a JPEG's zeros are not zero
        raise RecordingError("the mask is not a PNG", path, f"a file that begins with {start!r}", "a PNG")
    image = _decode(path, cv2.IMREAD_UNCHANGED)
    if image.ndim == 2:
        return np.asarray(image != 0)
    if image.shape[2] == 4 and (image[..., 3] != image[0, 0, 3]).any():
        return np.asarray(image[..., 3] != 0)
    return np.asarray((image[..., :3] != 0).any(axis=2))


def image_size(path: Path) -> tuple[int, int]:
    """(width, height) [px] of an image, from its header where that is simple. Raises RecordingError."""
    data = read_bytes(path, 1 << 16)
    if data.startswith(PNG_START) and len(data) >= 24:
        width, height = struct.unpack(">II", data[16:24])
        return width, height
    image = _decode(path, cv2.IMREAD_UNCHANGED)
    return image.shape[1], image.shape[0]


def read_bytes(path: Path, limit: int = -1) -> bytes:
    """The first `limit` bytes of a file (-1: all). Raises RecordingError."""
    try:
        with Path(path).open("rb") as file:
            return file.read(limit)
    # ValueError: a null byte in the name
    except (OSError, ValueError) as error:
        found = error.strerror if isinstance(error, OSError) and error.strerror else error
        raise RecordingError("an image cannot be read", path, found, "an image file") from error


def _decode(path: Path, flags: int) -> NDArray:
    data = read_bytes(path)
    problem = _damage(data)
    image = None
    if not problem:
        try:
            image = cv2.imdecode(np.frombuffer(data, np.uint8), flags)
        except cv2.error:
            image = None
    if image is None:
        do = "copy the file again or take its line out of the list"
        raise RecordingError("an image is damaged", path, problem or "no image data", "a whole PNG or JPEG file", do)
    return image


def _damage(data: bytes) -> str:
    """What is wrong with the bytes of an image file; empty when nothing shows.

    OpenCV fills what a cut file lacks, or writes to the terminal; so the container is looked at first.
    """
    if not data:
        return "an empty file"
    if data.startswith(PNG_START):
        return _png_damage(data)
    # some writers put a few bytes behind the end marker
    if data.startswith(JPEG_START) and b"\xff\xd9" not in data[-4096:]:
        return f"a file cut off after {len(data)} bytes"
    return ""


def _png_damage(data: bytes) -> str:
    at = len(PNG_START)
    while at + 12 <= len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        end = at + 12 + length
        if end > len(data):
            break
        (stated,) = struct.unpack(">I", data[end - 4 : end])
        if zlib.crc32(data[at + 4 : end - 4]) != stated:
            return f"a wrong check sum at byte {at}"
        if data[at + 4 : at + 8] == b"IEND":
            return ""
        at = end
    return f"a file cut off after {len(data)} bytes"
