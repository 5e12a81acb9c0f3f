"""Single images of a recording: whole files only, as arrays, with errors that name the file."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.limits import check_size
from fusion.files.reading import read_bytes as read_regular
from fusion.recording.images.header import (
    JPEG_START,
    OTHERS,
    PNG_START,
    ImageHeader,
    exif_turn,
    plain_png,
    read_header,
    tiff_values,
    whole_pnm,
)

HEAD = 1 << 16  # bytes that hold the header of an image
TAKES = 8  # times its own size: what is made of an image while it is used (as floats, turned about, laid side by side)
DO = "copy the file again or take its line out of the list"


def read_counts(path: Path, shape: tuple[int, int] | None = None) -> NDArray[np.uint16]:
    """(height, width) counts of a 16-bit grey image; of another shape than a given one it is not decoded.

    Raises:
        RecordingError: also for another kind of image.
    """
    return counts_in(read_bytes(path), path, shape)


def counts_in(data: bytes, path: Path, shape: tuple[int, int] | None = None) -> NDArray[np.uint16]:
    """The same of the bytes of an image that stands in another file; `path` names it. Raises RecordingError."""
    header = _header(data, path)
    if shape is not None:
        check_shape((header.height, header.width), shape, path)
    if (header.channels, header.depth) != (1, 2):
        found = f"{8 * header.depth} bit, {header.channels} channel(s)"
        raise RecordingError("the image is not a 16-bit grey image", path, found, "16-bit PNG with one channel")
    image = _tiff(data, path) if is_tiff(data) else _decoded(data, header, cv2.IMREAD_UNCHANGED, path)
    if image.dtype != np.uint16 or image.ndim != 2:
        raise RecordingError("the image is not a 16-bit grey image", path, "8 bit", "16-bit PNG with one channel")
    return image


def read_real(path: Path, shape: tuple[int, int]) -> NDArray[np.float32]:
    """(height, width) values of a TIFF of real numbers; of another shape it is not decoded. Raises RecordingError."""
    data = read_bytes(path)
    header = _header(data, path)
    check_shape((header.height, header.width), shape, path)
    if not is_tiff(data) or (header.channels, header.depth) != (1, 4):
        raise RecordingError("the image is not of real numbers", path, f"{8 * header.depth} bit", "a float32 TIFF")
    return _tiff(data, path).astype(np.float32)


def is_tiff(data: bytes) -> bool:
    """True where this is how a TIFF begins."""
    return OTHERS.get(data[:4]) == "TIFF"


def _tiff(data: bytes, path: Path) -> NDArray:
    try:
        return tiff_values(data)
    except ValueError as error:
        raise _damaged(path, error) from error


def read_color(path: Path, shape: tuple[int, int] | None = None) -> NDArray[np.uint8]:
    """(height, width, 3) RGB of an 8-bit image as it is stored; grey is repeated.

    Args:
        shape: (height, width) that its camera states; an image that has these the other way round is turned as its
            notes (EXIF) ask for, where they do.

    Raises:
        RecordingError: as `decode_image`.
    """
    return color_in(read_bytes(path), path, shape)


def color_in(data: bytes, path: Path, shape: tuple[int, int] | None = None) -> NDArray[np.uint8]:
    """The same of the bytes of an image that stands in another file; `path` names it. Raises RecordingError."""
    image = _decoded(data, _header(data, path), cv2.IMREAD_COLOR_RGB, path)
    if shape is not None and other_way(image.shape[:2], shape):
        image = np.rot90(image, exif_turn(data))
    return np.ascontiguousarray(image)


def other_way(size: tuple[int, ...], wanted: tuple[int, ...]) -> bool:
    """True where two sides are the wanted ones the other way round."""
    return size != wanted and size == wanted[::-1]


def grey_in(data: bytes, path: Path) -> NDArray[np.uint8]:
    """(height, width) values of an 8-bit grey image that stands in another file. Raises RecordingError."""
    image = _decoded(data, _header(data, path), cv2.IMREAD_UNCHANGED, path)
    if image.ndim != 2 or image.dtype != np.uint8:
        raise RecordingError("the image is not an 8-bit grey image", path, "another kind", "one channel of 8 bit")
    return image


def size_in(data: bytes, path: Path) -> tuple[int, int]:
    """(width, height) [px] of an image that stands in another file. Raises RecordingError."""
    header = _header(data, path)
    return header.width, header.height


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
    """(width, height) [px] of an image, from its header. Raises RecordingError."""
    data = read_bytes(path, HEAD)
    try:
        header = read_header(data)
    except ValueError:  # some cameras write a picture before the picture
        header = _header(read_bytes(path), path)
    return header.width, header.height


def check_shape(found: tuple[int, int], camera: tuple[int, int], path: Path) -> None:
    """Refuse a depth image (height, width) that is not of the camera's size. Raises RecordingError."""
    if found != camera:
        expected = f"{camera[1]} x {camera[0]}, the size of the camera"
        shown = f"{found[1]} x {found[0]}"
        raise RecordingError("the depth image has another size", path, shown, expected, "pass the right --camera")


def read_bytes(path: Path, limit: int = -1) -> bytes:
    """The first `limit` bytes of a file (-1: all). Raises RecordingError."""
    return read_regular(path, RecordingError, "an image", limit)


def decode_image(data: bytes, flags: int, path: Path, shape: tuple[int, int] | None = None) -> NDArray:
    """The image that these bytes are, with OpenCV's `flags`; of another shape than a given one it is not decoded.

    Raises:
        RecordingError: damaged, too large, or of another shape (height, width); `path` is named.
    """
    header = _header(data, path)
    if shape is not None:
        check_shape((header.height, header.width), shape, path)
    return _decoded(data, header, flags, path)


def _decode(path: Path, flags: int) -> NDArray:
    return decode_image(read_bytes(path), flags, path)


def _header(data: bytes, path: Path) -> ImageHeader:
    """What the header promises. Raises RecordingError where that is damaged, or too large to decode."""
    try:
        header = read_header(data)
    except ValueError as error:
        raise _damaged(path, error) from error
    check_size(TAKES * header.size, path, RecordingError, f"an image of {header.width} x {header.height} pixels")
    return header


def _decoded(data: bytes, header: ImageHeader, flags: int, path: Path) -> NDArray:
    """OpenCV fills what a cut file lacks, or writes to the terminal; so the container is looked at first."""
    try:
        if data.startswith(PNG_START):
            data = plain_png(data)
        elif data.startswith(JPEG_START) and b"\xff\xd9" not in data[-4096:]:  # a few bytes may follow the end marker
            raise ValueError(f"a file cut off after {len(data)} bytes")
        elif data.startswith(b"P"):
            data = whole_pnm(data, header)
        # as stored: cameras and poses are of these pixels; the turn in a photograph's notes (EXIF) is for showing it
        image = cv2.imdecode(np.frombuffer(data, np.uint8), flags | cv2.IMREAD_IGNORE_ORIENTATION)
    except (ValueError, cv2.error) as error:
        raise _damaged(path, error if isinstance(error, ValueError) else "no image data") from error
    if image is None:
        raise _damaged(path, "no image data")
    return image


def _damaged(path: Path, found: object) -> RecordingError:
    return RecordingError("an image is damaged", path, found, "a whole image file", DO)
