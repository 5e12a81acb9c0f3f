"""7-Scenes sequences: `frame-000000.depth.png`, `.color.png` or `.jpg`, `.pose.txt` (camera to world)."""

import re
from functools import partial
from pathlib import Path

import numpy as np

from fusion.errors import RecordingError
from fusion.files.content import FARTHEST_M
from fusion.files.inside import all_inside
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, is_rigid
from fusion.geometry.trajectory import Trajectory
from fusion.recording.cameras.presets import PRESETS
from fusion.recording.images.frame_files import FrameFiles
from fusion.recording.images.load_frame import load_frame
from fusion.recording.images.read import image_size
from fusion.recording.native.camera_file import camera_of_matrix
from fusion.recording.native.text_files import data_lines, number
from fusion.recording.recording import Recording

DEPTH = re.compile(r"frame-(\d+)\.depth(\.proj)?\.png$")
MATRIX = "*intrinsics*.txt"
COLOR = ("png", "jpg", "jpeg")  # the data set's own is PNG; recordings made after its pattern often are not
DEPTH_SCALE = 1000.0
# the files carry no time; Kinect v1 gives 30 frames a second
FRAMES_PER_SECOND = 30.0


def recognises(folder: Path) -> bool:
    """True for a folder with a 7-Scenes depth image."""
    return any(DEPTH.match(entry.name) for entry in folder.glob("frame-*"))


def read(folder: Path, camera: Camera | None) -> Recording:
    """The recording in a 7-Scenes sequence folder, by default with its usual camera. Raises RecordingError."""
    names = all_inside(folder, sorted(entry.name for entry in folder.iterdir()), RecordingError)
    depth = _depth_names(names)
    known = set(names)
    stems = [name.split(".")[0] for name in depth]
    color = [next((name for end in COLOR if (name := f"{stem}.color.{end}") in known), None) for stem in stems]
    stamps = np.array([int(stem.split("-")[1]) for stem in stems]) / FRAMES_PER_SECOND
    files = FrameFiles(folder=folder, depth=depth, color=color if any(color) else [])
    beside = _camera_beside(folder, depth[0])
    camera = camera or beside
    warnings = [] if camera else ["the camera is the data set's nominal one (585 px), not calibrated"]
    if any(color) and beside is None and not any(".proj." in name for name in depth):
        warnings.append("7-Scenes colour is not registered to depth: colours are shifted by some pixels")
    camera = camera or PRESETS["7scenes"][0]
    return Recording(
        path=folder,
        format="7scenes",
        camera=camera,
        timestamps=stamps,
        load=partial(load_frame, files, camera, stamps),
        poses=_poses(folder, [stem if f"{stem}.pose.txt" in known else None for stem in stems], stamps),
        warnings=tuple(warnings),
        files=files,
    )


def _camera_beside(folder: Path, first: str) -> Camera | None:
    """The camera of a matrix in the folder, as of tsdf-fusion, or above it, as of 3DMatch; its lens is not told."""
    names = all_inside(folder, sorted(path.name for path in folder.glob(MATRIX)), RecordingError)
    above = folder.parent / "camera-intrinsics.txt"
    path = folder / names[0] if names else above
    if not path.is_file():
        return None
    return camera_in(path, image_size(folder / first))


def camera_in(path: Path, size: tuple[int, int]) -> Camera:
    """The camera of a matrix (3 x 3, or 4 x 4 with nothing more) in a text file, for images of (width, height) [px].

    Raises:
        RecordingError: it is no camera's matrix.
    """
    rows = [[number(value, path, line) for value in text.split()] for line, text in data_lines(path)]
    K = np.array(rows) if len({len(row) for row in rows}) == 1 else np.zeros((0, 0))
    found = camera_of_matrix(K[:3, :3], size, DEPTH_SCALE)
    if found is None:
        raise RecordingError("the camera cannot be used", path, "", "3 rows of 3: fx 0 cx, 0 fy cy, 0 0 1 [px]")
    return found


def _depth_names(names: list[str]) -> list[str]:
    """One depth file per frame, in order; the projected one (registered to colour) where both stand there."""
    found: dict[int, str] = {}
    for name in names:
        match = DEPTH.match(name)
        if match and (int(match[1]) not in found or match[2]):
            found[int(match[1])] = name
    return [found[index] for index in sorted(found)]


def _poses(folder: Path, stems: list[str | None], stamps: Array) -> Trajectory | None:
    poses = np.full((len(stems), 4, 4), np.nan)
    for pose, stem in zip(poses, stems, strict=True):
        if stem is not None:
            pose[:] = read_matrix(folder / f"{stem}.pose.txt")
    return Trajectory(stamps, poses) if np.isfinite(poses).any() else None


def read_matrix(path: Path) -> Array:
    """The rigid (4, 4) in a text file of four rows; all NaN where tracking was lost. Raises RecordingError."""
    # lost tracking is written as -1.#IND, nan or -inf
    rows = [(line, text.split()) for line, text in data_lines(path)]
    if any("#" in value or "nan" in value.lower() or "inf" in value.lower() for _, row in rows for value in row):
        return np.full((4, 4), np.nan)
    values = [[number(value, path, line) for value in row] for line, row in rows]
    T = np.array(values) if len(values) == 4 and all(len(row) == 4 for row in values) else np.zeros(0)
    # 0.01: the data set's matrices are rounded and not re-orthonormalised
    if not is_rigid(T, 0.01) or np.abs(T).max() > FARTHEST_M:
        raise RecordingError(
            "the pose is not a rigid matrix", path, f"{len(rows)} rows", "4 rows of 4, camera to world"
        )
    return T
