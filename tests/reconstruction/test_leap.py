"""A leap of the track is told with its frame; what a hand does is not; and one frame has no drift."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.geometry.trajectory import Trajectory
from fusion.reconstruction.leap import leap_of
from fusion.results.course import Course
from tests.reconstruction.test_reconstruction_judgement import good

COUNT = 30


def along(steps: np.ndarray, times: np.ndarray | None = None) -> Trajectory:
    poses = np.tile(np.eye(4), (len(steps) + 1, 1, 1))
    poses[1:, 0, 3] = np.cumsum(steps)
    return Trajectory(np.arange(len(poses)) / 30 if times is None else times, poses)


def told_of(trajectory: Trajectory, found: int | None = None):
    return leap_of(trajectory, 0.03, np.arange(len(trajectory)) != found)


def test_a_leap_is_told_with_its_frame():
    steps = np.full(COUNT, 0.028)
    steps[10] = 0.459
    told = told_of(along(steps))
    assert told is not None and told.level == "bad" and told.do
    assert told_of(along(steps), found=11) is None  # by what it shows, after frames were left out
    assert "459 mm from frame 10 to frame 11" in told.reason and "28 mm" in told.reason
    result = replace(good(), trajectory=along(steps[:19]), course=Course(1.0, True, 1, 1))
    assert "Steps" in {light.subject for light in result.judgement.lights if light.level == "bad"}


@pytest.mark.parametrize(
    "steps",
    [
        np.full(COUNT, 0.028),
        np.r_[np.zeros(15), np.linspace(0, 0.1, 15)],  # still, then it gathers speed
        np.r_[np.full(15, 0.001), 0.02, np.full(15, 0.001)],  # less than what is fused hides
    ],
)
def test_a_hand_is_not_told(steps):
    assert told_of(along(steps)) is None


def test_a_gap_in_time_or_place_is_no_leap():
    steps = np.full(COUNT, 0.028)
    steps[10] = 0.459
    times = np.arange(COUNT + 1) / 30
    times[11:] += 0.5
    assert told_of(along(steps, times)) is None
    lost = along(np.full(COUNT, 0.028))
    lost.poses[5] = np.nan
    assert told_of(lost) is None


def test_one_frame_does_not_drift():
    one = Trajectory(np.zeros(1), np.eye(4)[None])
    result = replace(good(), trajectory=one, residual=np.full(1, np.nan), course=Course(0.0, True, 1, 1))
    assert "Drift" not in {light.subject for light in result.judgement.lights}
