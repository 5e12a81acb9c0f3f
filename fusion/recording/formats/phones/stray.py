"""Stray Scanner's folders: `depth/`, `confidence/`, `camera_matrix.csv`, `odometry.csv`, `rgb.mp4`.

docs.strayrobots.io/apps/scanner/format.html; poses are camera to world with OpenCV's camera axes, as the author's
own viewer (kekeblom/StrayVisualizer) takes them.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.content import FARTHEST_M
from fusion.files.inside import all_inside, inside
from fusion.files.limits import check_size
from fusion.files.npy import read_npy
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, from_tum
from fusion.geometry.trajectory import Trajectory
from fusion.recording.cameras.laid import in_proportion, out_of_proportion
from fusion.recording.formats.phones.arkit import (
    COARSE,
    LIDAR,
    UNKNOWN,
    Confidence,
    camera_of,
    confidence_of,
    depth_camera,
    noisier,
    sized,
    sure,
)
from fusion.recording.formats.phones.video import Video, open_video
from fusion.recording.formats.recorded.parts import even_or_stated
from fusion.recording.images.load_frame import counts_to_metres
from fusion.recording.images.read import check_shape, grey_in, image_size, read_bytes, read_counts
from fusion.recording.native.camera_file import are_focal
from fusion.recording.native.text_files import data_lines, number, stamp
from fusion.recording.recording import Recording
from fusion.recording.streamed import ImageSource, with_color_of

PICTURE = (1920, 1440)  # [px] what camera_matrix.csv is of, says the format
DEPTH_SCALE = 1000.0  # millimetres, in both kinds of files
FRAMES_PER_SECOND = 60.0  # of the phone, where an old file has no time stamps
COLUMNS = ("x", "y", "z", "qx", "qy", "qz", "qw")


@dataclass(frozen=True)
class StrayImages:
    """The depth images of a recording: names of their files, and of those that tell how sure they are."""

    folder: Path
    names: list[str]
    shape: tuple[int, int]
    confident: Confidence = UNKNOWN

    def counts(self, index: int) -> NDArray[np.uint16]:
        """(h, w) millimetres of a frame, 0 where missing. Raises RecordingError."""
        path = self.folder / self.names[index]
        if path.suffix == ".png":
            return read_counts(path, self.shape)
        values = read_npy(path, RecordingError, "a depth image")
        if values.ndim != 2:
            raise RecordingError("a depth image is no image", path, f"shape {values.shape}", "height and width")
        check_shape((values.shape[0], values.shape[1]), self.shape, path)
        return np.where((values > 0) & (values < 65535), np.nan_to_num(values), 0).astype(np.uint16)

    def depth(self, index: int) -> NDArray[np.float32]:
        """(h, w) [m] of a frame, NaN where missing. Raises RecordingError."""
        depth = counts_to_metres(self.counts(index), DEPTH_SCALE)
        return sure(depth, self.confidence(index) if self.confident.used else None)

    def noisier(self, index: int) -> NDArray[np.float32] | None:
        """As of a `Frame`. Raises RecordingError."""
        if not self.confident.used or self.confident.middle == 1:
            return None
        return noisier(self.confidence(index), self.confident.middle)

    def confidence(self, index: int) -> NDArray[np.uint8] | None:
        """(h, w) 0 to 2, or None where there is none. Raises RecordingError."""
        name = f"confidence/{Path(self.names[index]).stem}.png"
        if not (self.folder / name).is_file():
            return None
        image = grey_in(read_bytes(inside(self.folder, name, RecordingError)), self.folder / name)
        return image if image.shape == self.shape else None


def recognises(folder: Path) -> bool:
    """True for a folder with Stray Scanner's two tables."""
    return all((folder / name).is_file() for name in ("camera_matrix.csv", "odometry.csv"))


def read(folder: Path, camera: Camera | None) -> Recording:
    """The recording in a Stray Scanner folder. Raises RecordingError."""
    names = _depth_names(folder)
    if not names:
        raise RecordingError("the recording is empty", folder, "no depth image", "depth/000000.png and so on")
    shape = _shape(folder / names[0])
    images = StrayImages(folder, names, shape)
    images = replace(images, confident=confidence_of(images, len(names)))
    warnings = list(images.confident.told)
    video, more = open_video(folder, "rgb.mp4")
    warnings += more
    camera = replace(sized(camera, shape) if camera else _camera(folder, shape, video), depth_scale=DEPTH_SCALE)
    frames = [int(Path(name).stem) for name in names]
    stamps, poses, more = _odometry(inside(folder, "odometry.csv", RecordingError), frames)
    source = ImageSource(
        path=folder,
        camera=camera,
        stamps=stamps,
        depth=images.depth,
        noisier=images.noisier,
        color=None if video is None else lambda index: video.image(frames[index]),
        has_color=np.array([video is not None and frame < video.frames for frame in frames]),
        counts=images.counts,
    )
    warnings += more + [COARSE] * (max(shape) <= LIDAR[0])
    return source.recording("stray-scanner", poses, warnings)


def _depth_names(folder: Path) -> list[str]:
    """Names of the depth images, PNG before NPY, by their number."""
    place = inside(folder, "depth", RecordingError)
    found: dict[int, str] = {}
    for path in sorted(place.iterdir(), reverse=True) if place.is_dir() else []:  # .png comes after .npy
        if path.suffix in (".png", ".npy") and path.stem.isascii() and path.stem.isdigit() and len(path.stem) < 10:
            found.setdefault(int(path.stem), f"depth/{path.name}")
    return all_inside(folder, [found[number] for number in sorted(found)], RecordingError)


def _shape(path: Path) -> tuple[int, int]:
    """(height, width) of a depth image."""
    if path.suffix == ".png":
        width, height = image_size(path)
    else:
        values = read_npy(path, RecordingError, "a depth image")
        height, width = values.shape if values.ndim == 2 else (0, 0)
    check_size(64 * width * height, path, RecordingError, f"a frame of {width} x {height} pixels")
    return height, width


def _camera(folder: Path, shape: tuple[int, int], video: Video | None) -> Camera:
    """The depth camera, from that of the video."""
    path = inside(folder, "camera_matrix.csv", RecordingError)
    rows = [[number(value, path, line) for value in text.split(",")] for line, text in data_lines(path)]
    K = np.array(rows) if len(rows) == 3 and all(len(row) == 3 for row in rows) else np.zeros((3, 3))
    if not are_focal(K[0, 0], K[1, 1]) or K[2].tolist() != [0.0, 0.0, 1.0]:
        raise RecordingError("the camera matrix cannot be used", path, f"{len(rows)} rows", "3 rows of 3, pixels")
    size, lies = PICTURE if video is None else (video.width, video.height), (shape[1], shape[0])
    if not in_proportion(lies, size) and in_proportion(lies, size[::-1]):
        size = size[::-1]  # a video that was turned: the matrix is of images as the sensor lies, as depth is
    if not in_proportion(lies, size):
        raise out_of_proportion(lies, size, folder)
    color = camera_of(*size, K[0, 0], K[1, 1], K[0, 2], K[1, 2])
    camera = depth_camera(color, shape[1], shape[0])
    return camera if video is None else with_color_of(camera, color)


def _odometry(path: Path, frames: list[int]) -> tuple[NDArray[np.float64], Trajectory | None, list[str]]:
    """Time stamps and poses of the frames with depth. Frames that the table has not are told."""
    lines = list(data_lines(path))
    head = [name.strip() for name in lines[0][1].split(",")] if lines else []
    if not set(COLUMNS) <= set(head):
        expected = "timestamp, frame, " + ", ".join(COLUMNS)
        raise RecordingError("the table of poses cannot be read", path, ", ".join(head)[:60], expected)
    at = {name: head.index(name) for name in (*COLUMNS, "timestamp", "frame") if name in head}
    known: dict[int, tuple[float, Array]] = {}
    for row, (line, text) in enumerate(lines[1:]):
        parts = text.split(",")
        if len(parts) != len(head):
            raise RecordingError("a pose cannot be read", f"{path}, line {line}", repr(text[:60]), ", ".join(head)[:60])
        index = int(number(parts[at["frame"]], path, line)) if "frame" in at else row
        time = stamp(parts[at["timestamp"]], path, line) if "timestamp" in at else row / FRAMES_PER_SECOND
        values = np.array([number(parts[at[name]], path, line) for name in COLUMNS])
        # as of TUM's files
        if abs(float(values[3:] @ values[3:]) ** 0.5 - 1) > 0.05 or np.abs(values[:3]).max() > FARTHEST_M:
            raise RecordingError(
                "a pose cannot be used", f"{path}, line {line}", text[:60], "metres, a unit quaternion"
            )
        known[index] = time, from_tum(values)
    stamps = np.array([known[frame][0] if frame in known else np.nan for frame in frames])
    poses = np.array([known[frame][1] if frame in known else np.full((4, 4), np.nan) for frame in frames])
    lost = np.isnan(stamps)
    told = [] if "timestamp" in at else [f"no time stamps: frames are taken for {FRAMES_PER_SECOND:g} a second"]
    if lost.all():
        return np.array(frames) / FRAMES_PER_SECOND, None, ["odometry.csv names none of the depth images"]
    if lost.any():
        told.append(f"{int(lost.sum())} of {len(frames)} depth images are not in odometry.csv: their time is between")
        stamps = np.interp(frames, np.array(frames)[~lost], stamps[~lost])
    stamps, more = even_or_stated(stamps, FRAMES_PER_SECOND)
    return stamps, Trajectory(stamps, poses), told + more
