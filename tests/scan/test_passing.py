"""Pixels of what passes before an object are left out of its frames; the object's own stay."""

from dataclasses import replace

import numpy as np
import pytest
from owl_and_arm import COUNT, alone, frames_of, of_arm

from fusion.geometry import pose
from fusion.scan.finding.passing import without_passing
from fusion.simulation.scene.shapes import box
from fusion.turntable.views import Region

EVERYWHERE = Region(np.full(3, -9.0), np.full(3, 9.0))


def kept(frames, poses, arm):
    """Share of the pixels of the arm, or of the owl, that still have depth."""
    shares = []
    for before, after, T in zip(frames, without_passing(frames, EVERYWHERE, poses).frames, poses, strict=True):
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


def test_what_lies_on_the_object_in_one_frame_is_left_out_to_its_end():
    block = box((-0.05, -0.05, 0.02), (0.05, 0.05, 0.2), (200, 200, 200))
    frames, poses = frames_of((0,), block, ((0.0, -0.08, 0.06), (0.054, 0.01, 0.12)))  # 4 mm on the block's front
    frames = [noisy(alone(frame), 0.002) for frame in frames]
    clean = without_passing(frames, EVERYWHERE, poses).frames
    points = pose.transform(poses[0], frames[0].surface.points.astype(float))
    touching = (np.abs(points - (0.054, -0.015, 0.09)) < (0.001, 0.02, 0.02)).all(axis=-1)
    assert touching.sum() > 100 and np.isfinite(clean[0].depth[touching]).mean() < 0.1
    assert all(a is b for a, b in zip(frames[1:], clean[1:], strict=True))


def noisy(frame, sigma):
    """The frame with a stated noise [m] of each pixel, of which a mean over neighbours has less."""
    return replace(frame, surface=replace(frame.surface, sigma=np.full_like(frame.surface.sigma, sigma)))


def test_what_is_there_in_all_frames_stays():
    frames, poses = frames_of(range(COUNT))
    frames = [alone(frame) for frame in frames]
    assert kept(frames, poses, arm=True).min() > 0.97 and kept(frames, poses, arm=False).min() > 0.97


def test_frames_without_a_place_stay_as_they_are():
    frames, poses = frames_of((4,))
    nowhere = np.full_like(poses, np.nan)
    some = [*frames[:3], None]
    assert all(a is b for a, b in zip(without_passing(some, EVERYWHERE, nowhere[:4]).frames, some, strict=True))
    assert without_passing([], EVERYWHERE, nowhere[:0]).frames == []


@pytest.mark.parametrize("wide", [0.006, 0.008, 0.012])  # two to four pixels [m]
def test_what_shows_as_a_narrow_strip_beside_the_object_is_left_out(wide):
    block = box((-0.05, -0.05, 0.02), (0.05, 0.05, 0.2), (200, 200, 200))
    frames, poses = frames_of((0,), block, ((0.03, -0.05 - wide, 0.06), (0.05, -0.05, 0.14)))
    frames = [alone(frame) for frame in frames]
    clean = without_passing(frames, EVERYWHERE, poses).frames
    points = pose.transform(poses[0], frames[0].surface.points.astype(float))
    of_block, strip = np.abs(points[..., 1]) < 0.05, (points[..., 1] < -0.0505) & (np.abs(points[..., 2] - 0.1) < 0.03)
    left = np.isfinite(clean[0].depth)
    assert left[strip].mean() < 0.2 and left[of_block & np.isfinite(frames[0].depth)].mean() > 0.97
    assert all(a is b for a, b in zip(frames[1:], clean[1:], strict=True))


def test_what_passes_where_the_image_stands_still_is_left_out():
    """The volume takes such pixels, too: on a round object they stand still, and what passes may be seen there only."""
    frames, poses = frames_of((4,))
    frames = [alone(frame) for frame in frames]
    still = replace(EVERYWHERE, still=np.ones(frames[0].depth.shape, bool))
    passing = of_arm(pose.transform(poses[4], frames[4].surface.points.astype(float))) & np.isfinite(frames[4].depth)
    assert np.isfinite(without_passing(frames, still, poses).frames[4].depth[passing]).mean() < 0.25
