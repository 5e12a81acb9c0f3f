"""Open3D's and Redwood's folders: `depth/*.png` (PGM, TIFF), `color/*.jpg`, camera and trajectory optional."""

import re
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.content import FARTHEST_M, Content
from fusion.files.inside import all_inside, inside, part
from fusion.files.json_file import read_json
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, is_rigid
from fusion.geometry.trajectory import Trajectory
from fusion.recording.cameras.matrix_files import camera_of_others
from fusion.recording.cameras.presets import say_camera
from fusion.recording.formats.recorded.parts import FRAMES_PER_SECOND, even_or_stated, no_stamps
from fusion.recording.formats.tum import with_color_placed
from fusion.recording.images.frame_files import FrameFiles
from fusion.recording.images.load_frame import load_frame
from fusion.recording.images.read import image_size
from fusion.recording.native.text_files import data_lines, number
from fusion.recording.recording import Recording

COLOR_FOLDERS = ("color", "rgb", "image")
CAMERA_FILES = ("intrinsic.json", "camera_intrinsic.json")
IMAGES = {".png", ".jpg", ".jpeg", ".pgm", ".ppm", ".tif", ".tiff"}
# Redwood: frame number - microseconds
REDWOOD = re.compile(r"\d+-(\d{6,})$")


def recognises(folder: Path) -> bool:
    """True for a folder with depth images and a folder of colour images, Open3D's camera or trajectory beside it."""
    beside = any((folder / name).is_dir() for name in COLOR_FOLDERS) or any(
        (folder / name).is_file() for name in (*CAMERA_FILES, "trajectory.log")
    )
    return beside and (folder / "depth").is_dir() and bool(images_in(folder, "depth"))


def read(folder: Path, camera: Camera | None) -> Recording:
    """The recording in an Open3D or Redwood folder. Raises RecordingError."""
    depth = images_in(folder, "depth")
    color = next((found for name in COLOR_FOLDERS if (found := images_in(folder, name))), [])
    camera = camera or camera_in(folder, depth)
    stamps, warnings = _stamps(depth)
    matched, told = matching(depth, color)
    warnings += told
    files, more = with_color_placed(FrameFiles(folder=folder, depth=depth, color=matched), camera)
    return Recording(
        path=folder,
        format="open3d",
        camera=camera,
        timestamps=stamps,
        load=partial(load_frame, files, camera, stamps),
        poses=_poses(folder, stamps),
        warnings=(*warnings, *more),
        files=files,
    )


def images_in(folder: Path, name: str) -> list[str]:
    """The images in a folder of that name, with it, by the number in their names."""
    if not (folder / name).is_dir():
        return []
    names = [entry.name for entry in (folder / name).iterdir() if entry.suffix.lower() in IMAGES]
    listed = [f"{name}/{file}" for file in sorted(names, key=lambda file: (number_in(file), file))]
    return all_inside(folder, listed, RecordingError)


def matching(depth: list[str], color: list[str]) -> tuple[list[str | None], list[str]]:
    """The colour image of each depth image, and what is told of that."""
    if len(color) in (0, len(depth)):
        return list(color), []
    count = f"{len(depth)} depth and {len(color)} colour images"
    for key, how in ((number_in, "the number"), (_common, "the words")):
        known = {key(name): name for name in color}
        found = [known.get(key(name)) for name in depth]
        # a name that stands for two says nothing of either
        if len(known) == len(color) and len({*map(key, depth)}) == len(depth) and any(found):
            return found, [f"{count}: joined by {how} in their names"]
    return [], [f"{count}: colour is left out, as names do not tell which belong together"]


def _common(name: str) -> str:
    """What a depth image and its colour image share in their names."""
    return re.sub(r"depth|colou?r|rgb|image|[^a-z0-9]", "", Path(name).stem.lower())


def number_in(name: str) -> int:
    """The frame number in a file name: the first run of digits (Redwood puts the time behind it)."""
    digits = re.search(r"[0-9]+", Path(name).stem)
    return int(digits[0][:18]) if digits else -1


def _stamps(names: list[str]) -> tuple[NDArray[np.float64], list[str]]:
    times = [REDWOOD.match(Path(name).stem) for name in names]
    if all(times):
        return even_or_stated(np.array([int(match[1][:18]) for match in times if match]) * 1e-6, FRAMES_PER_SECOND)
    return no_stamps(len(names))


def camera_in(folder: Path, depth: Sequence[str] = ()) -> Camera:
    """The camera beside the images of depth. Raises RecordingError: there is none, or one that cannot be used."""
    path = next((part(folder, name, RecordingError) for name in CAMERA_FILES if (folder / name).is_file()), None)
    if path is None:
        size = partial(image_size, folder / depth[0]) if depth else None
        found = "depth images of {} x {}, ".format(*size()) if size else ""
        do = say_camera("primesense", folder, size)
        raise RecordingError("the recording has no camera", folder, found + "no intrinsic.json", "intrinsics", do)
    return camera_of_others(Content(read_json(path, RecordingError), path, "the camera", RecordingError))


def _poses(folder: Path, stamps: Array) -> Trajectory | None:
    path = next(iter(sorted(folder.glob("*.log"))), None)
    return None if path is None else read_log(inside(folder, path.name, RecordingError), stamps)


def read_log(path: Path, stamps: Array) -> Trajectory:
    """Poses of a Redwood log: blocks of `frame frame count` and a 4x4, camera to world. Raises RecordingError."""
    lines = list(data_lines(path))
    poses = np.full((len(stamps), 4, 4), np.nan)
    for start in range(0, len(lines), 5):
        block = [[number(value, path, line) for value in text.split()] for line, text in lines[start : start + 5]]
        where = f"{path}, line {lines[start][0]}"
        if len(block) != 5 or len(block[0]) != 3 or any(len(row) != 4 for row in block[1:]):
            raise RecordingError("a pose cannot be read", where, "", "three numbers, then four rows of four")
        T, index = np.array(block[1:]), block[0][0]
        # 0.01: logs are written with few decimals
        if not is_rigid(T, 0.01) or np.abs(T).max() > FARTHEST_M:
            raise RecordingError("a pose is not rigid", where)
        if 0 <= index < len(poses):
            poses[int(index)] = T
    return Trajectory(stamps, poses)
