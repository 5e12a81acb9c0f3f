"""Motion: how fast a camera moves at every frame, in a hand or seen from what turns before it."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fusion.recording.native.scene_file import CourseFields, stated_scene
from fusion.recording.recording import Recording
from fusion.simulation.rendering.motion import twist_between

STEADY_S = 0.5  # frames that follow each other faster, each at a pose of its own, are taken while it moves


def twists_of(recording: Recording) -> NDArray[np.float64]:
    """(n, 6) motion of the camera in the frame of its poses at every frame, as `twist_between`, from the frames before
    and after; 0 where it stands still, or where nobody knows."""
    stamps = np.asarray(recording.timestamps, float)
    out = np.zeros((len(stamps), 6))
    if recording.poses is None or len(stamps) < 2:
        return out
    poses = recording.poses.at(recording.timestamps).poses
    same = [np.allclose(one, other, atol=1e-9) for one, other in pairwise(poses)]
    about = stated_scene(recording).trajectory
    said = about.continuous if isinstance(about, CourseFields) else None
    moving = said if said is not None else not any(same) and float(np.median(np.diff(stamps))) < STEADY_S
    if not moving:
        return out
    for i in range(len(stamps)):
        before, after = max(i - 1, 0), min(i + 1, len(stamps) - 1)
        if stamps[after] > stamps[before] and np.isfinite(poses[[before, after]]).all():
            out[i] = twist_between(poses[before], poses[after], stamps[after] - stamps[before])
    return out
