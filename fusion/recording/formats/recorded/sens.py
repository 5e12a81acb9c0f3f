"""ScanNet's `.sens`, version 4: a head with both cameras, then pose, colour and depth of each frame.

Layout: ScanNet/SensReader. Depth extrinsics take points of the depth camera to the colour camera.
"""

import struct
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.content import FARTHEST_M
from fusion.files.limits import check_size
from fusion.files.reading import open_regular
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, inverse, is_rigid
from fusion.geometry.trajectory import Trajectory
from fusion.recording.formats.recorded.parts import ByteRange, counts_of, even_or_stated, read_part, unzipped
from fusion.recording.images.load_frame import counts_to_metres
from fusion.recording.images.read import color_in
from fusion.recording.native.camera_file import are_focal
from fusion.recording.recording import Recording
from fusion.recording.streamed import ImageSource

VERSION = 4
LONGEST_NAME = 4096  # of the sensor
HEAD = struct.Struct("<64f2i4IfQ")  # four matrices, two ways of packing, sizes, counts per metre, number of frames
FRAME = struct.Struct("<16f4Q")  # pose, two stamps, two sizes
RAW, PNG, JPEG = 0, 1, 2  # of colour
ZLIB, OCCI = 1, 2  # of depth; raw is 0 as well
TAKES = 400  # bytes in memory for each frame's place
FRAMES_PER_SECOND = 30.0


@dataclass(frozen=True)
class Head:
    """What a file says of all frames."""

    name: str
    matrices: Array
    color_packed: int
    depth_packed: int
    color_size: tuple[int, int]
    depth_size: tuple[int, int]
    scale: float
    frames: int
    end: int


@dataclass(frozen=True)
class FramePlace:
    """Where a frame lies."""

    pose: tuple[float, ...]
    stamp: int
    color: ByteRange
    depth: ByteRange


def recognises(path: Path) -> bool:
    """True for a file with the head of a `.sens`."""
    return path.is_file() and _head(path) is not None


def read(path: Path, camera: Camera | None) -> Recording:
    """The recording in a `.sens` file; whole frames of one that was cut off. Raises RecordingError."""
    head = _head(path)
    if head is None:
        raise RecordingError("this is no .sens file of version 4", path)
    if head.depth_packed not in (RAW, ZLIB):
        found = "OCCI" if head.depth_packed == OCCI else f"kind {head.depth_packed}"
        raise RecordingError("depth is packed in a way that is not read", path, found, "zlib, or not at all")
    places = _places(path, head)
    if not places:
        raise RecordingError("the recording is empty", path, "no whole frame", "one or more")
    warnings = [f"cut off: {len(places)} of {head.frames} frames are whole"] if len(places) < head.frames else []
    camera = replace(camera or _camera(head, path), depth_scale=head.scale)
    stamps, more = even_or_stated(np.array([place.stamp for place in places]) * 1e-6, FRAMES_PER_SECOND)
    counts = partial(_counts, path, head, places)
    source = ImageSource(
        path=path,
        camera=camera,
        stamps=stamps,
        depth=lambda index: counts_to_metres(counts(index), camera.depth_scale),
        color=partial(_color, path, head, places),
        has_color=np.array([place.color.size > 0 for place in places]),
        counts=counts,
    )
    if camera.T_color_depth is not None and not np.allclose(camera.T_color_depth, np.eye(4)):
        more.append("poses are taken for the depth camera's")
    return source.recording("sens", _poses(places, stamps), warnings + more)


def _head(path: Path) -> Head | None:
    """The head of a file, or None where it is none of this format."""
    try:
        with open_regular(path, RecordingError, takes=0) as file:
            version, length = struct.unpack("<IQ", file.read(12))
            if version != VERSION or length > LONGEST_NAME:
                return None
            name = file.read(length)
            values = HEAD.unpack(file.read(HEAD.size))
            end = file.tell()
    except (RecordingError, struct.error, OSError):
        return None
    color_packed, depth_packed, cw, ch, dw, dh, scale, frames = values[64:]
    sizes_fit = 0 < min(dw, dh) <= max(dw, dh) <= 65535 and max(cw, ch) <= 65535
    if (
        not sizes_fit
        or not 1e-3 <= scale <= 1e7
        or color_packed not in range(-1, 3)
        or depth_packed not in range(-1, 3)
    ):
        return None
    matrices = np.array(values[:64]).reshape(4, 4, 4)
    return Head(name.decode("ascii", "replace").rstrip("\0"), matrices, color_packed, depth_packed,
                (cw, ch), (dw, dh), float(scale), frames, end)  # fmt: skip


def _places(path: Path, head: Head) -> list[FramePlace]:
    """Where the whole frames lie; a frame that claims more than there is ends them."""
    places: list[FramePlace] = []
    with open_regular(path, RecordingError, "the recording", takes=0) as file:
        size = file.seek(0, 2)
        # no more frames than their heads have room
        check_size(TAKES * min(head.frames, size // FRAME.size), path, RecordingError, "the list of frames")
        at = head.end
        while len(places) < head.frames and at + FRAME.size <= size:
            file.seek(at)
            *pose, _, depth_stamp, color_size, depth_size = FRAME.unpack(file.read(FRAME.size))
            color = ByteRange(at + FRAME.size, color_size)
            depth = ByteRange(color.begin + color_size, depth_size)
            at = depth.begin + depth_size
            if at > size:
                break
            places.append(FramePlace(tuple(pose), depth_stamp, color, depth))
    return places


def _counts(path: Path, head: Head, places: list[FramePlace], index: int) -> NDArray[np.uint16]:
    shape = head.depth_size[1], head.depth_size[0]
    data = read_part(path, places[index].depth, "a depth image")
    where = f"{path}, frame {index}"
    if head.depth_packed == ZLIB:
        data = unzipped(data, 2 * shape[0] * shape[1], where, "a depth image")
    return counts_of(data, shape, where)


def _color(path: Path, head: Head, places: list[FramePlace], index: int) -> NDArray[np.uint8] | None:
    part = places[index].color
    if not part.size:
        return None
    data = read_part(path, part, "a colour image")
    if head.color_packed != RAW:
        return color_in(data, path)
    width, height = head.color_size
    if len(data) != 3 * width * height:
        found = f"{len(data)} bytes"
        raise RecordingError("a colour image is of another size", path, found, f"{width} x {height} pixels")
    return np.frombuffer(data, np.uint8).reshape(height, width, 3).copy()


def _camera(head: Head, path: Path) -> Camera:
    color_matrix, color_place, depth_matrix, depth_place = head.matrices
    camera = _pinhole(depth_matrix, head.depth_size, path, head)
    if not min(head.color_size):
        return camera
    color = _pinhole(color_matrix, head.color_size, path, head)
    T = np.eye(4)
    # 0.01: as of other files that are written with few decimals
    if is_rigid(color_place, 0.01) and is_rigid(depth_place, 0.01):
        T = inverse(color_place) @ depth_place
    over = np.allclose(T, np.eye(4), atol=1e-6) and np.allclose(color.parameters, camera.parameters, rtol=1e-3)
    return camera if over and color.shape == camera.shape else replace(camera, color=color, T_color_depth=T)


def _pinhole(K: Array, size: tuple[int, int], path: Path, head: Head) -> Camera:
    if not np.isfinite(K[:2, :3]).all() or not are_focal(K[0, 0], K[1, 1]) or np.abs(K[:2, 2]).max() > 1e6:
        raise RecordingError(
            "the camera cannot be used", path, K[:2, :3].tolist(), "focal lengths [px]", "pass --camera"
        )
    fx, fy, cx, cy = (float(K[i, j]) for i, j in ((0, 0), (1, 1), (0, 2), (1, 2)))
    return Camera(*size, fx, fy, cx, cy, depth_scale=head.scale, sensor=head.name[:60])


def _poses(places: list[FramePlace], stamps: Array) -> Trajectory | None:
    """Camera to world; where tracking was lost the numbers are infinite, or no pose."""
    poses = np.array([place.pose for place in places]).reshape(-1, 4, 4)
    good = [is_rigid(T, 0.01) and np.abs(T[:3, 3]).max() <= FARTHEST_M for T in poses]
    poses[~np.array(good)] = np.nan
    return Trajectory(stamps, poses) if any(good) else None
