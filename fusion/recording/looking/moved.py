"""Where a recording itself says that camera or scene was moved: its log and its poses. Images are not looked at."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fusion.recording.native.scene_file import stated_scene
from fusion.recording.recording import Recording

STEP_M, STEP_RAD = 0.005, 0.005  # stated places that differ by less are one: a laser distance meter scatters by 1 mm
STEP_DEG = 0.05  # of a turntable
SIGMAS = 5.0  # or poses by as many of their stated standard deviations


def moved(recording: Recording) -> NDArray[np.bool_]:
    """(n - 1,) True where something was moved between two frames by `distance_m`, `turntable_deg` or the poses."""
    found = np.zeros(max(len(recording) - 1, 0), bool)
    for column, step in (("distance_m", STEP_M), ("turntable_deg", STEP_DEG)):
        values = recording.telemetry_at_frames(column)
        if values is not None:
            found |= _steps(values, step)
    if recording.poses is not None and len(recording.poses) and len(found):
        found |= _pose_steps(recording)
    return found


def unmoved_parts(recording: Recording) -> list[range]:
    """Frame numbers of the parts between the moves that are stated; the whole recording where none is."""
    cuts = [0, *(int(i) + 1 for i in np.flatnonzero(moved(recording))), len(recording)]
    return [range(a, b) for a, b in pairwise(cuts)]


def _steps(values: NDArray[np.floating], step: float) -> NDArray[np.bool_]:
    """(n - 1,) True where a value leaves the first one of its part by more than a step: many small ones are one."""
    found, anchor = np.zeros(max(len(values) - 1, 0), bool), values[0] if len(values) else 0.0
    for i, value in enumerate(values[1:]):
        if not abs(value - anchor) <= step and np.isfinite(value):
            found[i], anchor = True, value
    return found


def wandered(recording: Recording, frames: slice = slice(None)) -> tuple[float, float]:
    """How far [m] and by what angle [rad] the stated poses went on from the first third of some frames to the last.

    0 without poses. What they scatter by is their own noise, and no motion.
    """
    if recording.poses is None or not len(recording.poses):
        return 0.0, 0.0
    T = recording.poses.at(recording.timestamps, np.inf).poses[frames]
    T = T[np.isfinite(T).all(axis=(1, 2))]
    some = len(T) // 3
    if not some:
        return 0.0, 0.0
    first, last = T[:some].mean(axis=0), T[-some:].mean(axis=0)
    away = float(np.linalg.norm(last[:3, 3] - first[:3, 3]))
    return away, float(np.linalg.norm(last[:3, :3] - first[:3, :3]) / np.sqrt(2))


def _pose_steps(recording: Recording) -> NDArray[np.bool_]:
    """(n - 1,) True where the stated pose nearest in time is another one."""
    assert recording.poses is not None
    stated = stated_scene(recording).stated_poses
    far, turn = max(STEP_M, SIGMAS * (stated.sigma_m or 0.0)), max(STEP_RAD, SIGMAS * (stated.sigma_rad or 0.0))
    T = recording.poses.at(recording.timestamps, np.inf).poses
    away = np.linalg.norm(np.diff(T[:, :3, 3], axis=0), axis=1)
    # |R1 - R2| = 2 sqrt(2) sin(angle / 2), which is 1.41 angles where they are small
    turned = np.linalg.norm(np.diff(T[:, :3, :3], axis=0), axis=(1, 2)) / np.sqrt(2)
    return np.asarray((away > far) | (turned > turn))
