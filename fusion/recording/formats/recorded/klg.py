"""ElasticFusion's and Logger2's `.klg`: frames of packed depth in millimetres and colour; neither size nor camera."""

import struct
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.limits import check_size
from fusion.files.reading import open_regular
from fusion.geometry.camera import Camera
from fusion.recording.cameras.presets import say_camera
from fusion.recording.formats.recorded.parts import ByteRange, counts_of, even_or_stated, read_part, unzipped
from fusion.recording.images.header import read_header
from fusion.recording.images.load_frame import counts_to_metres
from fusion.recording.images.read import color_in
from fusion.recording.recording import Recording
from fusion.recording.streamed import ImageSource

COUNT = struct.Struct("<i")
FRAME = struct.Struct("<qii")  # microseconds, bytes of depth and of colour
TAKES = 300  # bytes in memory for each frame's place
VGA = (480, 640)  # (height, width) what the format takes for granted
FRAMES_PER_SECOND = 30.0
DEPTH_SCALE = 1000.0  # millimetres, in every writer


def recognises(path: Path) -> bool:
    """True for a file whose first frame is one of this format and whose count of frames fits into it."""
    try:
        with open_regular(path, RecordingError, takes=0) as file:
            size = file.seek(0, 2)
            file.seek(0)
            (frames,) = COUNT.unpack(file.read(COUNT.size))
            stamp, depth, color = FRAME.unpack(file.read(FRAME.size))
            start = file.read(2)
            file.seek(COUNT.size + FRAME.size + depth)
            picture = file.read(2)
    except (RecordingError, struct.error, OSError, ValueError):
        return False
    if not 0 < frames <= size // FRAME.size or stamp < 0 or depth <= 2 or color < 0:
        return False
    packed = depth == 2 * VGA[0] * VGA[1] or (start[0] & 15 == 8 and int.from_bytes(start, "big") % 31 == 0)
    shown = color in (0, 3 * VGA[0] * VGA[1]) or picture == b"\xff\xd8"
    return packed and shown and COUNT.size + FRAME.size + depth + color <= size


def read(path: Path, camera: Camera | None) -> Recording:
    """The recording in a `.klg` file; whole frames of one that was cut off. Raises RecordingError."""
    stamped, depth, color, claimed = _places(path)
    shape = _shape(path, depth[0], color[0])
    if camera is None:
        do = say_camera("primesense")
        raise RecordingError("the recording has no camera", path, "images alone", "intrinsics", do)
    if not camera.width:
        camera = replace(camera, width=shape[1], height=shape[0])
    camera = replace(camera, depth_scale=DEPTH_SCALE)
    stamps, warnings = even_or_stated(np.array(stamped) * 1e-6, FRAMES_PER_SECOND)
    warnings += [f"cut off: {len(depth)} of {claimed} frames are whole"] if len(depth) < claimed else []
    has_color = np.array([part.size > 0 for part in color])
    warnings += ["writers of this format differ in the order of red and blue"] if has_color.any() else []
    counts = partial(_counts, path, depth, shape)
    source = ImageSource(
        path=path,
        camera=camera,
        stamps=stamps,
        depth=lambda index: counts_to_metres(counts(index), DEPTH_SCALE),
        color=partial(_color, path, color, shape),
        has_color=has_color,
        counts=counts,
    )
    return source.recording("klg", None, warnings)


def _places(path: Path) -> tuple[list[int], list[ByteRange], list[ByteRange], int]:
    """Stamps [us], depth and colour of the whole frames, and how many the file claims."""
    stamps: list[int] = []
    depths: list[ByteRange] = []
    colors: list[ByteRange] = []
    with open_regular(path, RecordingError, "the recording", takes=0) as file:
        size = file.seek(0, 2)
        file.seek(0)
        (claimed,) = COUNT.unpack(file.read(COUNT.size))
        check_size(TAKES * min(claimed, size // FRAME.size), path, RecordingError, "the list of frames")
        at = COUNT.size
        while len(stamps) < claimed and at + FRAME.size <= size:
            file.seek(at)
            stamp, depth, color = FRAME.unpack(file.read(FRAME.size))
            begin = at + FRAME.size
            at = begin + depth + color
            if depth < 0 or color < 0 or at > size:
                break
            stamps.append(stamp)
            depths.append(ByteRange(begin, depth))
            colors.append(ByteRange(begin + depth, color))
    if not stamps:
        raise RecordingError("the recording is empty", path, "no whole frame", "one or more")
    return stamps, depths, colors, claimed


def _shape(path: Path, depth: ByteRange, color: ByteRange) -> tuple[int, int]:
    """(height, width) of the images: as the first picture says, else what the format takes for granted."""
    size = depth.size
    if size != 2 * VGA[0] * VGA[1]:
        try:
            data = read_part(path, color, "a colour image")
            header = read_header(data) if data else None
        except ValueError:
            header = None
        if header is not None:
            check_size(64 * header.width * header.height, path, RecordingError, "a frame")
            return header.height, header.width
    return VGA


def _counts(path: Path, places: list[ByteRange], shape: tuple[int, int], index: int) -> NDArray[np.uint16]:
    data, most = read_part(path, places[index], "a depth image"), 2 * shape[0] * shape[1]
    where = f"{path}, frame {index}"
    return counts_of(data if len(data) == most else unzipped(data, most, where, "a depth image"), shape, where)


def _color(path: Path, places: list[ByteRange], shape: tuple[int, int], index: int) -> NDArray[np.uint8] | None:
    part = places[index]
    if not part.size:
        return None
    data = read_part(path, part, "a colour image")
    if len(data) == 3 * shape[0] * shape[1] and not data.startswith(b"\xff\xd8"):
        return np.frombuffer(data, np.uint8).reshape(*shape, 3).copy()
    return color_in(data, path)
