"""nerfstudio's `transforms.json` with depth: poses with OpenGL's axes, pixels counted from the image's corner.

Its rays go through (column + 0.5 - cx) / fl_x (nerfstudio, cameras.py, get_image_coords), so its principal point lies
half a pixel from OpenCV's. Format: docs.nerf.studio, "Data conventions".
"""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
from msgspec import Meta, Struct
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.content import Content, Metres
from fusion.files.inside import all_inside, part
from fusion.files.json_file import read_json
from fusion.files.reading import beginning
from fusion.geometry.camera import Camera
from fusion.geometry.lens_forms import fisheye, polynomial, with_lens
from fusion.geometry.pose import Array, inverse, is_rigid, other_axes
from fusion.geometry.trajectory import Trajectory
from fusion.recording.cameras.laid import in_proportion, out_of_proportion
from fusion.recording.cameras.own_cameras import common_camera
from fusion.recording.formats.folders.plain import metres, natural
from fusion.recording.formats.recorded.parts import FRAMES_PER_SECOND
from fusion.recording.images.frame_files import FrameFiles
from fusion.recording.images.load_frame import counts_to_metres, load_frame, stored_shape, with_color_turned
from fusion.recording.images.read import image_size, read_color, read_counts
from fusion.recording.native.camera_file import Centre, Focal, Size, are_focal
from fusion.recording.native.text_files import LATEST
from fusion.recording.recording import Recording
from fusion.recording.streamed import REAL_SCALE, ImageSource, with_color_of

NAME = "transforms.json"
MILLIMETRES = 1e-3  # nerfstudio's depth_unit_scale_factor where none is said
FISHEYE = "OPENCV_FISHEYE"
PERSPECTIVE = ("OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL")
Lens = Annotated[float, Meta(gt=-1e3, lt=1e3, description="of the lens")]
_Row = Annotated[list[Metres], Meta(min_length=4, max_length=4)]
Matrix = Annotated[list[_Row], Meta(min_length=3, max_length=4, description="3 or 4 rows of 4, camera to world")]


class NerfstudioIntrinsics(Struct, frozen=True, kw_only=True):
    """A camera, for all frames or of one."""

    fl_x: Focal | None = None
    fl_y: Focal | None = None
    cx: Centre | None = None
    cy: Centre | None = None
    w: Size | None = None
    h: Size | None = None
    camera_angle_x: Annotated[float, Meta(gt=0, lt=3.1, description="[rad]")] | None = None
    k1: Lens | None = None
    k2: Lens | None = None
    k3: Lens | None = None
    k4: Lens | None = None
    p1: Lens | None = None
    p2: Lens | None = None


class ShownFrame(NerfstudioIntrinsics, frozen=True, kw_only=True):
    """One image."""

    transform_matrix: Matrix
    file_path: str = ""
    depth_file_path: str | None = None
    timestamp: Annotated[float, Meta(gt=-LATEST, lt=LATEST, description="seconds")] | None = None


class NerfstudioFile(NerfstudioIntrinsics, frozen=True, kw_only=True):
    """A `transforms.json`."""

    frames: list[ShownFrame]
    camera_model: str = "OPENCV"
    applied_transform: Matrix | None = None
    applied_scale: Annotated[float, Meta(gt=1e-6, lt=1e6, description="above 0")] = 1.0
    depth_unit_scale_factor: Annotated[float, Meta(ge=1e-7, le=1e3, description="metres per count")] | None = None


def recognises(path: Path) -> bool:
    """True for a folder with a `transforms.json`, or for that file whatever its name."""
    if path.is_dir():
        return (path / NAME).is_file()
    if not beginning(path, 64).lstrip(b"\xef\xbb\xbf \r\n\t").startswith(b"{"):
        return False
    try:
        frames = read_json(path, RecordingError).get("frames")
    except RecordingError:
        return False
    return isinstance(frames, list) and any(isinstance(f, dict) and "transform_matrix" in f for f in frames[:1])


def read(path: Path, camera: Camera | None) -> Recording:
    """The frames with depth of a nerfstudio data set. Raises RecordingError."""
    folder = path if path.is_dir() else path.parent
    path = part(path, NAME, RecordingError) or path if path.is_dir() else path
    content = Content(read_json(path, RecordingError), path, "the data set", RecordingError)
    given = content.as_type(NerfstudioFile)
    frames = sorted((f for f in given.frames if f.depth_file_path), key=lambda f: natural(f.file_path))
    if not frames:
        do = "images alone have no size in metres: open the recording that they came from"
        raise RecordingError("no frame has depth", path, f"{len(given.frames)} frames", "depth_file_path", do)
    depth = all_inside(folder, [str(f.depth_file_path) for f in frames], RecordingError, path)
    color = all_inside(folder, [f.file_path for f in frames], RecordingError, path)
    factor = given.depth_unit_scale_factor or MILLIMETRES
    warnings = _told(given, len(frames))
    stamps, more = _stamps(frames)
    warnings += more
    own: dict[int, Camera] = {}
    if camera is None:
        camera, own, more = _cameras(given, frames, content, folder)
        warnings += more
    camera = replace(camera, depth_scale=REAL_SCALE if depth[0].endswith(".npy") else 1 / factor)
    poses = Trajectory(stamps, _poses(given, frames, content))
    there: list[str | None] = [name if name and (folder / name).is_file() else None for name in color]
    shape = (camera.color or camera).shape
    if own or depth[0].endswith(".npy"):
        source = ImageSource(
            path=folder,
            camera=camera,
            stamps=stamps,
            depth=partial(_depth, folder, depth, camera, factor),
            color=lambda index: read_color(folder / name, shape) if (name := there[index]) else None,
            has_color=np.array([name is not None for name in there]),
            own=own,
            stored=stored_shape(folder, there),
        )
        return source.recording("nerfstudio", poses, warnings)
    files, shown, more = with_color_turned(FrameFiles(folder=folder, depth=depth), there, camera)
    if any(shown):
        files = replace(files, **{"color_apart" if camera.color is not None else "color": shown})  # type: ignore[arg-type]
    warnings += more
    return Recording(
        path=folder,
        format="nerfstudio",
        camera=camera,
        timestamps=stamps,
        load=partial(load_frame, files, camera, stamps),
        poses=poses,
        warnings=tuple(warnings),
        files=files,
    )


def _depth(folder: Path, names: list[str], camera: Camera, factor: float, index: int) -> NDArray[np.float32]:
    if names[index].endswith(".npy"):
        return metres(folder, names, camera.shape, index) * np.float32(factor)
    return counts_to_metres(read_counts(folder / names[index], camera.shape), 1 / factor)


def _told(given: NerfstudioFile, used: int) -> list[str]:
    told = []
    if given.depth_unit_scale_factor is None:
        told.append("the depth unit is not said: taken for nerfstudio's usual millimetres")
    if used < len(given.frames):
        told.append(f"{len(given.frames) - used} of {len(given.frames)} frames have no depth: left out")
    if given.applied_scale != 1.0:
        told.append(f"the scale {given.applied_scale:g} that was applied to the poses is taken back")
    return told


def _stamps(frames: list[ShownFrame]) -> tuple[NDArray[np.float64], list[str]]:
    """Those that are stated for all frames in this order, else even ones."""
    times = [frame.timestamp for frame in frames]
    if None not in times and (np.diff(np.array(times, float)) > 0).all():
        return np.array(times, float), []
    return np.arange(len(frames)) / FRAMES_PER_SECOND, [
        f"no time stamps: frames are taken for {FRAMES_PER_SECOND:g} a s"
    ]


def _cameras(
    given: NerfstudioFile, frames: list[ShownFrame], content: Content, folder: Path
) -> tuple[Camera, dict[int, Camera], list[str]]:
    """The depth camera, those of frames that see otherwise, and what to tell."""
    if given.camera_model not in (*PERSPECTIVE, FISHEYE):
        expected = ", ".join((*PERSPECTIVE, FISHEYE))
        raise RecordingError(
            "the lens of this data set is not read", content.where, given.camera_model[:40], expected,
            "undistort the images, and their depth",
        )  # fmt: skip
    first = folder / str(frames[0].depth_file_path)
    size = _size(given, frames, folder)
    seen = [_camera(given, frame, size, content) for frame in frames]
    width, height = size if first.suffix == ".npy" else image_size(first)
    if not in_proportion((width, height), size):
        raise out_of_proportion((width, height), size, content.where)
    picture = Camera(*size, 1.0, 1.0, 0.0, 0.0)
    across, down = width / size[0], height / size[1]
    # from the corner everything scales alike; then to the centre of the first pixel
    stated = np.array(seen) * [across, down, across, down] - [0, 0, 0.5, 0.5]
    camera, own, warnings = common_camera(picture.resized(width, height), stated)
    camera = _with_lens(camera, given, frames, content)
    own = {index: replace(one, distortion=camera.distortion) for index, one in own.items()}
    return with_color_of(camera, camera.resized(*size)), own, warnings


def _size(given: NerfstudioFile, frames: list[ShownFrame], folder: Path) -> tuple[int, int]:
    """(width, height) of the images that the intrinsics are of."""
    width, height = frames[0].w or given.w, frames[0].h or given.h
    if width and height:
        return int(width), int(height)
    picture = folder / frames[0].file_path
    return image_size(picture if frames[0].file_path and picture.is_file() else folder / str(frames[0].depth_file_path))


def _camera(given: NerfstudioFile, frame: ShownFrame, size: tuple[int, int], content: Content) -> list[float]:
    """fl_x, fl_y, cx, cy of a frame, its own before those of all."""
    width, height = size
    fx, angle = frame.fl_x or given.fl_x, frame.camera_angle_x or given.camera_angle_x
    if fx is None and angle is not None:
        fx = width / 2 / float(np.tan(angle / 2))
    if fx is None:
        raise content.wrong(NerfstudioFile, "fl_x")
    fy = frame.fl_y or given.fl_y or fx
    if not are_focal(fx, fy):
        raise content.wrong(NerfstudioFile, "camera_angle_x")
    cx = frame.cx if frame.cx is not None else given.cx
    cy = frame.cy if frame.cy is not None else given.cy
    return [fx, fy, width / 2 if cx is None else cx, height / 2 if cy is None else cy]


def _with_lens(camera: Camera, given: NerfstudioFile, frames: list[ShownFrame], content: Content) -> Camera:
    """The camera with the lens, one for all frames."""
    names = ("k1", "k2", "k3", "k4", "p1", "p2")
    lenses = {tuple(float(getattr(frame, name) or getattr(given, name) or 0.0) for name in names) for frame in frames}
    if len(lenses) > 1:
        raise RecordingError("frames have different lenses", content.where, f"{len(lenses)} of them", "one for all")
    *k, p1, p2 = lenses.pop()
    try:
        if given.camera_model == FISHEYE:
            return with_lens(camera, fisheye(k))[0]
        if k[3]:  # a fourth radial term is not known to OpenCV
            return with_lens(camera, polynomial(k), (p1, p2))[0]
    except ValueError as problem:
        do = "undistort the images, and their depth"
        raise RecordingError("the lens of this data set cannot be used", content.where, problem, do=do) from problem
    return replace(camera, distortion=(k[0], k[1], p1, p2, k[2]))


def _poses(given: NerfstudioFile, frames: list[ShownFrame], content: Content) -> Array:
    """(n, 4, 4) camera to world with OpenCV's axes, in the world before anything was applied to it."""
    applied = np.eye(4)
    if given.applied_transform is not None:
        applied[:3] = np.array(given.applied_transform)[:3]
        if not is_rigid(applied, 0.01):
            raise content.wrong(NerfstudioFile, "applied_transform", expected="a rotation and a shift")
    poses = np.empty((len(frames), 4, 4))
    for T_world_camera, frame in zip(poses, frames, strict=True):
        T = np.eye(4)
        T[:3] = np.array(frame.transform_matrix)[:3]
        T[:3, 3] /= given.applied_scale
        # 0.01: as of other files that are written with few decimals
        if not is_rigid(T, 0.01):
            at = given.frames.index(frame)
            raise content.wrong(
                NerfstudioFile, "frames", at, "transform_matrix", expected="a rigid matrix, camera to world"
            )
        T_world_camera[:] = other_axes(inverse(applied) @ T)
    return poses
