"""Trajectories as TUM text files: `timestamp tx ty tz qx qy qz qw`, camera to world."""

from pathlib import Path

import numpy as np

from fusion.errors import RecordingError
from fusion.files.content import FARTHEST_M
from fusion.files.output.publish import atomic_file
from fusion.geometry.pose import from_tum, to_tum
from fusion.geometry.trajectory import Trajectory
from fusion.recording.native.text_files import data_lines, number, stamp

HEADER = "# timestamp tx ty tz qx qy qz qw\n"


def read_trajectory(path: Path) -> Trajectory:
    """The poses of a TUM trajectory file, in the order of their time stamps.

    Raises:
        RecordingError: no pose, or a line without eight finite numbers or with a quaternion far from unit length.
    """
    path = Path(path)
    rows = []
    for line, text in data_lines(path):
        parts = text.replace(",", " ").split()
        if len(parts) != 8:
            expected = "timestamp tx ty tz qx qy qz qw"
            raise RecordingError("a pose cannot be read", f"{path}, line {line}", repr(text[:60]), expected)
        row = [stamp(parts[0], path, line), *(number(part, path, line) for part in parts[1:])]
        if max(map(abs, row[1:4])) > FARTHEST_M:
            expected = f"metres, up to {FARTHEST_M:g}"
            raise RecordingError("a pose is out of bounds", f"{path}, line {line}", " ".join(parts[1:4])[:60], expected)
        # 0.05: files with two decimals are still read, other orders or units are not
        if abs(sum(q * q for q in row[4:]) ** 0.5 - 1) > 0.05:
            raise RecordingError("a quaternion is not of unit length", f"{path}, line {line}", " ".join(parts[4:]))
        rows.append(row)
    if not rows:
        raise RecordingError("the trajectory is empty", path, "no pose", "lines timestamp tx ty tz qx qy qz qw")
    values = np.array(rows)
    values = values[np.argsort(values[:, 0], kind="stable")]
    return Trajectory(values[:, 0], np.stack([from_tum(row[1:]) for row in values]))


def write_trajectory(path: Path, trajectory: Trajectory) -> None:
    """Write a TUM trajectory file, whole or not at all; frames without a pose are left out."""
    with atomic_file(Path(path)) as partial:
        partial.write_text(trajectory_text(trajectory), encoding="utf-8")


def trajectory_text(trajectory: Trajectory) -> str:
    """The content of a TUM trajectory file; frames without a pose are left out."""
    lines = [
        f"{stamp:.6f} " + " ".join(f"{value:.9f}" for value in to_tum(T))
        for stamp, T, valid in zip(trajectory.timestamps, trajectory.poses, trajectory.valid, strict=True)
        if valid
    ]
    return HEADER + "".join(line + "\n" for line in lines)
