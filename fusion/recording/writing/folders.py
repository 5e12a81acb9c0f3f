"""Writing a recording as folders that other programs read: TUM RGB-D's and Open3D's.

Depth keeps its counts, time stamps their microseconds. What such a folder has no place for is told.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.recording.native.trajectory_file import trajectory_text
from fusion.recording.recording import Recording
from fusion.recording.writing.losses import BESIDE, Watched
from fusion.recording.writing.write import depth_counts, tell, write_frames, write_png

MILLIMETRES, TUM_COUNTS = 1000.0, 5000.0  # counts a metre that Open3D, and TUM's own tools, take depth for
LATEST_S = 1e12  # what a name holds of microseconds


def fill_tum(folder: Path, recording: Recording, notes: list[str] | None = None) -> None:
    """A folder of the TUM RGB-D benchmark into one that is being made: lists, images, poses, pairs of both.

    `associations.txt` holds a line of colour and depth for each frame that has both, as ORB-SLAM and others read it.

    Args:
        recording: its colour in the depth camera's pixels is written.
        notes: what is to be known about the result is appended here.

    Raises:
        RecordingError: no frame, or one that cannot be read.
    """
    frames = _watched(recording)
    write_frames(folder, recording.camera, (replace(frame, ir=None) for frame in frames))
    pairs = _pairs(folder)
    if pairs:
        (folder / "associations.txt").write_text("\n".join([*pairs, ""]), encoding="utf-8")
    if recording.poses is not None and recording.poses.valid.any():
        (folder / "groundtruth.txt").write_text(trajectory_text(recording.poses), encoding="utf-8")
    camera = recording.camera
    numbers = ",".join(f"{value:g}" for value in (camera.fx, camera.fy, camera.cx, camera.cy))
    told = [f"a TUM folder holds no camera: its focal lengths and centre are {numbers} px"]
    if camera.depth_scale != TUM_COUNTS:
        told.append(f"a metre is {camera.depth_scale:g} counts of depth, where TUM's own tools take {TUM_COUNTS:g}")
    tell(recording.path, (*recording.warnings, *told, *frames.told()), notes)


def fill_open3d(folder: Path, recording: Recording, notes: list[str] | None = None) -> None:
    """A folder as Open3D's reconstruction system takes it, into one that is being made.

    Images are called by their number and microseconds, as Redwood does, so that their time comes back. Arguments and
    errors as of `fill_tum`; a time stamp before 0 is refused, too.
    """
    (folder / "depth").mkdir()
    bare, frames = 0, _watched(recording)
    for frame in frames:
        if not 0 <= frame.timestamp <= LATEST_S:
            raise RecordingError("a time stamp cannot be a file's name", recording.path, frame.timestamp, "0 s or more")
        name = f"{frame.index:07d}-{round(frame.timestamp * 1e6):012d}.png"
        write_png(folder / "depth" / name, depth_counts(frame.depth, recording.camera.depth_scale))
        bare += frame.color is None
        if frame.color is not None:
            (folder / "color").mkdir(exist_ok=True)
            write_png(folder / "color" / name, frame.color)
    camera = recording.camera
    content = {
        "width": camera.width,
        "height": camera.height,
        "intrinsic_matrix": camera.matrix.T.ravel().tolist(),  # column by column
        "depth_scale": camera.depth_scale,  # Open3D does not read it, this program does
    }
    (folder / "intrinsic.json").write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    poses = None if recording.poses is None else recording.poses.at(recording.timestamps).poses
    if poses is not None and np.isfinite(poses).any():
        (folder / "trajectory.log").write_text(_log_text(poses), encoding="utf-8")
    told = ["the lens is left out: Open3D knows none, undistort for it"] if any(camera.distortion) else []
    if camera.depth_scale != MILLIMETRES:
        told.append(f"Open3D takes {MILLIMETRES:g} counts for a metre unless told: depth_scale={camera.depth_scale:g}")
    if 0 < bare < len(recording):
        told.append(f"{bare} frames have no colour; Open3D joins images by their order")
    tell(recording.path, (*recording.warnings, *told, *frames.told()), notes)


def _pairs(folder: Path) -> list[str]:
    """A line of colour and depth for each frame that has both: their files have one name."""
    if not (folder / "rgb.txt").exists():
        return []
    lines = {kind: (folder / f"{kind}.txt").read_text(encoding="utf-8").splitlines()[2:] for kind in ("rgb", "depth")}
    depth = {Path(line).name: line for line in lines["depth"]}
    return [f"{line} {depth[Path(line).name]}" for line in lines["rgb"]]


def _watched(recording: Recording) -> Watched:
    if not len(recording):
        raise RecordingError("there is no frame to write", recording.path, "no frame", "one or more")
    return Watched(recording, without=BESIDE)


def _log_text(poses: NDArray[np.float64]) -> str:
    """Redwood's log: number twice and the next, then the rows of the camera's place in the world."""
    blocks = []
    for number, T in enumerate(poses):
        if np.isfinite(T).all():
            rows = [" ".join(f"{value:.12g}" for value in row) for row in T]
            blocks.append("\n".join([f"{number} {number} {number + 1}", *rows]))
    return "\n".join([*blocks, ""])
