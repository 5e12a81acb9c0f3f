"""Images in messages, raw or packed, as counts, metres or colours."""

import struct
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.limits import check_size
from fusion.recording.formats.bags.containers.store import Topic
from fusion.recording.formats.bags.messages.rvl import unpack_rvl
from fusion.recording.formats.bags.messages.values import RosValues, decoded
from fusion.recording.images.header import JPEG_START, PNG_START
from fusion.recording.images.read import decode_image

IMAGE, COMPRESSED = "sensor_msgs/Image", "sensor_msgs/CompressedImage"
TAKES = 8  # as in fusion.recording.images.read
COUNTS = {"16uc1", "mono16", "z16", "y16"}
METRES = {"32fc1"}
GREYS = {"mono8", "8uc1", "gray", "y8"}
JPEG = {"mjpg"}  # one to an image, under the name of its stream
# encoding: channels of 8 bit, and what OpenCV calls the way to RGB
COLORS = {
    "rgb8": (3, None),
    "bgr8": (3, cv2.COLOR_BGR2RGB),
    "8uc3": (3, cv2.COLOR_BGR2RGB),
    "rgba8": (4, cv2.COLOR_RGBA2RGB),
    "bgra8": (4, cv2.COLOR_BGRA2RGB),
    "8uc4": (4, cv2.COLOR_BGRA2RGB),
    "mono8": (1, cv2.COLOR_GRAY2RGB),
    "8uc1": (1, cv2.COLOR_GRAY2RGB),
    "yuv422": (2, cv2.COLOR_YUV2RGB_UYVY),
    "uyvy": (2, cv2.COLOR_YUV2RGB_UYVY),
    "yuv422_yuy2": (2, cv2.COLOR_YUV2RGB_YUYV),
    "yuy2": (2, cv2.COLOR_YUV2RGB_YUYV),
    "yuyv": (2, cv2.COLOR_YUV2RGB_YUYV),
    # OpenCV names a pattern by its second row and column
    "bayer_rggb8": (1, cv2.COLOR_BayerBG2RGB),
    "bayer_bggr8": (1, cv2.COLOR_BayerRG2RGB),
    "bayer_gbrg8": (1, cv2.COLOR_BayerGR2RGB),
    "bayer_grbg8": (1, cv2.COLOR_BayerGB2RGB),
}


@dataclass(frozen=True)
class FirstImage:
    """What the first image of a topic is: `kind` "depth", "color", "grey" or "" (not read), its size [px]."""

    kind: str
    encoding: str
    width: int
    height: int
    metres: bool = False
    rest: bytes = b""


def look_at(topic: Topic) -> FirstImage:
    """What a topic of images holds, by its first message. Raises RecordingError."""
    found = decoded(topic, topic.read(0, -1))
    values = found.values
    encoding = encoding_of(topic, values)
    if topic.type == IMAGE:
        width, height = int(values["width"]), int(values["height"])
        kind = _kind(encoding)
    else:
        image = _unpacked(topic, values)
        height, width = image.shape[:2]
        kind = "depth" if encoding in COUNTS | METRES else "grey" if image.ndim == 2 else "color"
    return FirstImage(kind, encoding, width, height, encoding in METRES, found.rest)


def encoding_of(topic: Topic, values: RosValues) -> str:
    """The encoding of the image that a message holds, in small letters."""
    if topic.type == IMAGE:
        return str(values.get("encoding", "")).lower()
    first, _, rest = str(values.get("format", "")).lower().partition(";")
    # old recorders of depth name the packing alone
    return first.strip() if rest or "compresseddepth" not in first else "16uc1"


def depth_image(topic: Topic, index: int, shape: tuple[int, int]) -> NDArray[np.uint16] | NDArray[np.float32]:
    """Depth (h, w) of a message: counts uint16, or metres float32 with NaN where missing. Raises RecordingError."""
    values = decoded(topic, topic.read(index, -1)).values
    encoding = encoding_of(topic, values)
    where = f"{topic.name}, message {index}"
    if topic.type != IMAGE:
        image = _unpacked(topic, values, shape)
    elif encoding in METRES:
        image = _pixels(values, 1, np.dtype("f4"), where)
    elif encoding in COUNTS:
        image = _pixels(values, 1, np.dtype("u2"), where)
    else:
        raise RecordingError("the image is no depth image", where, repr(encoding[:40]), "16UC1 or 32FC1")
    if image.shape != shape:
        found, expected = f"{image.shape[1]} x {image.shape[0]}", f"{shape[1]} x {shape[0]}, the size of the camera"
        raise RecordingError("the depth image has another size", where, found, expected, "pass the right --camera")
    if image.dtype == np.uint16:
        return np.asarray(image, np.uint16)
    metres = np.asarray(image, np.float32)
    return np.where(np.isfinite(metres) & (metres > 0), metres, np.float32(np.nan))


def color_image(topic: Topic, index: int) -> NDArray[np.uint8]:
    """Colours (h, w, 3) RGB of a message. Raises RecordingError."""
    values = decoded(topic, topic.read(index, -1)).values
    where = f"{topic.name}, message {index}"
    if topic.type != IMAGE:
        image = decode_image(bytes(values["data"]), cv2.IMREAD_COLOR, Path(where))
        return np.ascontiguousarray(image[..., ::-1])
    encoding = encoding_of(topic, values)
    if encoding in JPEG:
        return np.ascontiguousarray(decode_image(bytes(values["data"]), cv2.IMREAD_COLOR, Path(where))[..., ::-1])
    if encoding not in COLORS:
        raise RecordingError("the image is no colour image", where, repr(encoding[:40]), ", ".join(COLORS))
    channels, way = COLORS[encoding]
    image = _pixels(values, channels, np.dtype("u1"), where)
    try:
        return np.ascontiguousarray(image if way is None else cv2.cvtColor(image, way))
    except cv2.error as problem:
        raise RecordingError("a colour image cannot be read", where, f"{encoding} {image.shape}") from problem


def grey_image(topic: Topic, index: int) -> NDArray[np.uint16]:
    """Counts (h, w) of an infrared image of 8 or 16 bit. Raises RecordingError."""
    values = decoded(topic, topic.read(index, -1)).values
    where = f"{topic.name}, message {index}"
    if topic.type != IMAGE:
        image = decode_image(bytes(values["data"]), cv2.IMREAD_UNCHANGED, Path(where))
    else:
        image = _pixels(values, 1, np.dtype("u2" if encoding_of(topic, values) in COUNTS else "u1"), where)
    if image.ndim != 2:
        raise RecordingError("the infrared image is not grey", where, f"{image.shape[2]} channels", "one channel")
    return image.astype(np.uint16)


def _kind(encoding: str) -> str:
    if encoding in COUNTS | METRES:
        return "depth"
    return "grey" if encoding in GREYS else "color" if encoding in COLORS or encoding in JPEG else ""


def _pixels(values: RosValues, channels: int, kind: np.dtype, where: str) -> NDArray:
    """The pixels of a raw image: rows of `step` bytes."""
    height, width, step = int(values["height"]), int(values["width"]), int(values["step"])
    kind, data = kind.newbyteorder(">" if values["is_bigendian"] else "<"), np.asarray(values["data"], np.uint8)
    row = width * channels * kind.itemsize
    check_size(TAKES * row * height, where, RecordingError, f"an image of {width} x {height} pixels")
    if not row or not height or step < row or len(data) < step * (height - 1) + row:
        raise RecordingError("an image is damaged", where, f"{len(data)} bytes", f"{step} x {height}")
    if len(data) < step * height:  # the last row without what fills it up
        data = np.concatenate([data, np.zeros(step * height - len(data), np.uint8)])
    rows = np.ascontiguousarray(data[: step * height].reshape(height, step)[:, :row])
    image = rows.view(kind).reshape(height, width, channels)
    return (image if channels > 1 else image[..., 0]).astype(kind.newbyteorder("="), copy=False)


def _unpacked(topic: Topic, values: RosValues, shape: tuple[int, int] | None = None) -> NDArray:
    """The image of a CompressedImage; depth of 32FC1 as metres. compressed_depth_image_transport of ROS."""
    data, form, where = bytes(values["data"]), str(values.get("format", "")).lower(), Path(topic.name)
    if data.startswith((PNG_START, JPEG_START)):
        return decode_image(data, cv2.IMREAD_UNCHANGED, where, shape)
    if "compresseddepth" not in form or len(data) < 12:
        raise RecordingError("a packed image is of no known kind", where, repr(form[:40]), "png, jpeg, compressedDepth")
    _, a, b = struct.unpack_from("<iff", data)
    if "rvl" in form or not data.startswith(PNG_START, 12):
        image: NDArray = _rvl(data[12:], where)
    else:
        image = decode_image(data[12:], cv2.IMREAD_UNCHANGED, where, shape)
    if image.ndim != 2 or image.dtype != np.uint16:
        raise RecordingError("the depth image is not of 16 bit", where, f"{image.dtype}, {image.ndim} axes", "16UC1")
    if encoding_of(topic, values) not in METRES:
        return image
    # depth is stored as a / z + b, in equal steps of the inverse
    inverse = image.astype(np.float32) - np.float32(b)
    known = (image > 0) & (inverse > 0)
    return np.where(known, np.float32(a) / np.where(known, inverse, 1), np.nan).astype(np.float32)


def _rvl(data: bytes, where: Path) -> NDArray[np.uint16]:
    width, height = struct.unpack_from("<II", data.ljust(8, b"\0"))
    check_size(TAKES * 2 * width * height, where, RecordingError, f"an image of {width} x {height} pixels")
    try:
        return unpack_rvl(data[8:], width, height)
    except ValueError as problem:
        raise RecordingError("an image is damaged", where, problem, "RVL data") from problem
