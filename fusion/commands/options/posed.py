"""Stated poses, as options name them and say how they are meant."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from fusion.errors import RecordingError

if TYPE_CHECKING:
    from fusion.geometry.trajectory import Trajectory
    from fusion.recording.recording import Recording

# of fusion/geometry/conventions.py, which is too much to load for --help
NAMES = ("opencv", "world-to-camera", "opengl", "opengl-view", "ros", "unity", "w-first")


def add_pose_convention(parser: argparse.ArgumentParser) -> None:
    """The option that says what the numbers of poses mean."""
    parser.add_argument(
        "--pose-convention",
        choices=NAMES,
        help="how the poses are meant (default opencv: camera to world, y down, z forward); fusion info tells",
    )


def stated_poses(name: str | Path | None, convention: str | None, recording: "Recording") -> "Trajectory | None":
    """The poses of a file, or the recording's own for `stated` and where only a convention is given; None for neither.

    Raises:
        RecordingError: the file cannot be read, or the recording's own are asked for and it states none.
    """
    from fusion.geometry.conventions import CONVENTIONS
    from fusion.recording.native.trajectory_file import read_trajectory

    if name is None and convention is None:
        return None
    own = name is None or str(name) in ("stated", "groundtruth")
    poses = recording.poses if own else read_trajectory(Path(str(name)))
    if poses is None:
        raise RecordingError("the recording states no poses", recording.path, do="pass a TUM trajectory with --poses")
    return replace(poses, poses=CONVENTIONS[convention or "opencv"].read(poses.poses))
