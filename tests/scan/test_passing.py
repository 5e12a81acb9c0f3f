"""Pixels of what passes before an object are left out of its frames; the object's own stay."""

import numpy as np
import pytest
from owl_and_arm import COUNT, alone, frames_of, of_arm

from fusion.geometry import pose
from fusion.scan.finding.passing import without_passing
from fusion.turntable.views import Region

EVERYWHERE = Region(np.full(3, -9.0), np.full(3, 9.0))


def kept(frames, poses, arm):
    """Share of the pixels of the arm, or of the owl, that still have depth."""
    shares = []
    for before, after, T in zip(frames, without_passing(frames, EVERYWHERE, poses), poses, strict=True):
        of = of_arm(pose.transform(T, before.surface.points.astype(float)))
        which = np.isfinite(before.depth) & np.isfinite(before.surface.normals[..., 0]) & (of == arm)
        if which.any():
            shares.append(np.isfinite(after.depth[which]).mean())
    return np.array(shares)


@pytest.mark.parametrize("arm_in", [(4,), (4, 5), (2, 9, 15)])
def test_an_arm_in_some_frames_is_left_out_there(arm_in):
    frames, poses = frames_of(arm_in)
    frames = [alone(frame) for frame in frames]
    assert kept(frames, poses, arm=True).max() < 0.25  # its rims are seen at a slant, of which nothing is said
    owl = kept(frames, poses, arm=False)
    assert owl.min() > 0.93 and np.median(owl) > 0.99  # but for pixels beside the arm


def test_what_is_there_in_all_frames_stays():
    frames, poses = frames_of(range(COUNT))
    frames = [alone(frame) for frame in frames]
    assert kept(frames, poses, arm=True).min() > 0.97 and kept(frames, poses, arm=False).min() > 0.97


def test_frames_without_a_place_stay_as_they_are():
    frames, poses = frames_of((4,))
    nowhere = np.full_like(poses, np.nan)
    some = [*frames[:3], None]
    assert all(a is b for a, b in zip(without_passing(some, EVERYWHERE, nowhere[:4]), some, strict=True))
    assert without_passing([], EVERYWHERE, nowhere[:0]) == []
