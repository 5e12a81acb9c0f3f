"""Writing a recording as a native folder, frame by frame, whole or not at all."""

import json
import logging
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fusion.errors import RecordingError
from fusion.files.output.publish import output_folder
from fusion.geometry.camera import Camera
from fusion.geometry.trajectory import Trajectory
from fusion.recording.images.frame_files import INVALID_COUNT
from fusion.recording.images.png import png_bytes
from fusion.recording.native.camera_file import write_camera
from fusion.recording.native.telemetry_file import telemetry_text
from fusion.recording.native.trajectory_file import trajectory_text
from fusion.recording.recording import Frame

# everything a native folder may hold: what an older recording left there would be read as part of the new one
LISTS = {"depth": "depth maps", "rgb": "color images", "ir": "infrared images", "raw": "values as the device sent them"}
MEMBERS = (
    "camera.json",
    *LISTS,
    *(f"{name}.txt" for name in LISTS),
    "groundtruth.txt",
    "telemetry.csv",
    "scene.json",
    "device.json",
)

_log = logging.getLogger("fusion")


def write_recording(  # one argument per part of the folder
    path: Path | str,
    camera: Camera,
    frames: Iterable[Frame],
    poses: Trajectory | None = None,
    telemetry: Mapping[str, ArrayLike] | None = None,
    scene: Mapping[str, Any] | None = None,
) -> None:
    """Write a native folder; `frames` is walked once and nothing is kept, so it may be long.

    Args:
        path: the folder; an older recording in it is replaced, other files are left alone.
        camera: its `depth_scale` rounds the depth to counts; depth beyond 65534 counts becomes missing.
        frames: in any order of time; written and numbered as they come.
        poses: stated poses; frames without one are left out.
        telemetry: columns (m,) with "timestamp".
        scene: content of `scene.json`.

    Raises:
        RecordingError: no frame, an image that has another size than the camera, a stamp that is not finite.
        FusionError: the folder cannot be made.

    >>> camera = fusion.Camera(64, 48, fx=60.0, fy=60.0, cx=31.5, cy=23.5)
    >>> wall = np.full(camera.shape, 1.2, np.float32)
    >>> fusion.write_recording("wall", camera, (fusion.Frame(i, i / 30, wall) for i in range(3)))
    >>> fusion.open_recording("wall")
    <Recording wall: native, 3 frames of 64 x 48 in 0.1 s; depth>
    """
    with output_folder(Path(path), replaces=MEMBERS) as partial:
        fill_recording(partial, camera, frames, poses, telemetry, scene)


def fill_recording(  # as write_recording
    folder: Path,
    camera: Camera,
    frames: Iterable[Frame],
    poses: Trajectory | None = None,
    telemetry: Mapping[str, ArrayLike] | None = None,
    scene: Mapping[str, Any] | None = None,
) -> None:
    """The same into a folder that is being made."""
    write_camera(folder / "camera.json", camera)
    write_frames(folder, camera, frames)
    if poses is not None and poses.valid.any():
        (folder / "groundtruth.txt").write_text(trajectory_text(poses), encoding="utf-8")
    if telemetry:
        (folder / "telemetry.csv").write_text(telemetry_text(telemetry), encoding="utf-8")
    if scene:
        (folder / "scene.json").write_text(json.dumps(dict(scene), indent=1) + "\n", encoding="utf-8")


def depth_counts(depth: NDArray[np.floating], depth_scale: float) -> NDArray[np.uint16]:
    """(height, width) counts of depth [m], to the nearest; 0 where missing, not positive or beyond 65534 counts."""
    with np.errstate(invalid="ignore", over="ignore"):
        counts = np.rint(np.asarray(depth) * depth_scale)  # in the precision of the depth
        good = (counts > 0) & (counts < INVALID_COUNT)
    return np.where(good, counts, 0).astype(np.uint16)


def tell(path: Path, told: Iterable[str], notes: list[str] | None) -> None:
    """What is to be known of a recording that was written: to the notes, else as warnings."""
    for text in told:
        if notes is None:
            _log.warning("%s: %s", path, text)
        else:
            notes.append(text)


def write_frames(folder: Path, camera: Camera, frames: Iterable[Frame]) -> None:
    """Write the images and the lists that name them, line by line in the order of the frames.

    Raises:
        RecordingError: as `write_recording`.
    """
    lists: dict[str, list[str]] = {}
    count = 0
    for count, frame in enumerate(frames, start=1):
        if not np.isfinite(frame.timestamp):
            raise RecordingError("a time stamp is not finite", f"frame {count - 1}", frame.timestamp, "seconds")
        images = {"depth": depth_counts(frame.depth, camera.depth_scale), "rgb": frame.color, "ir": frame.ir}
        for name, image in images.items():
            if image is None:
                continue
            if name not in lists:
                (folder / name).mkdir()
                lists[name] = [f"# {LISTS[name]}", "# timestamp filename"]
            file = f"{name}/{count - 1:06d}.png"
            _write_png(folder / file, image, camera)
            lists[name].append(f"{frame.timestamp:.6f} {file}")
    if count == 0:
        raise RecordingError("there is no frame to write", folder.name, "no frame", "one or more")
    for name, lines in lists.items():
        (folder / f"{name}.txt").write_text("\n".join([*lines, ""]), encoding="utf-8")


def _write_png(path: Path, image: NDArray, camera: Camera) -> None:
    if image.shape[:2] != camera.shape:
        found = f"{image.shape[1]} x {image.shape[0]}" if image.ndim > 1 else image.shape
        raise RecordingError("an image has another size than the camera", path.name, found, f"{camera.shape[::-1]}")
    write_png(path, image)


def write_png(path: Path, image: NDArray) -> None:
    """An RGB image (h, w, 3) uint8, or counts (h, w) as uint16."""
    path.write_bytes(png_bytes(image))
