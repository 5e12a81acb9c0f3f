"""A push of the object or of the camera is found in freely tracked poses; their slow wandering is not taken for one."""

import numpy as np
import pytest

from fusion.geometry import pose
from fusion.turntable.jumps import BESIDE, find_jump

COUNT, AT = 60, 37
MIDDLE = np.array([0.0, 0.0, 0.08])


def poses(seed: int, wander: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """By the axis, and as tracked: 0.3 mm of noise, and an error that goes round once in a turn."""
    rng = np.random.default_rng(seed)
    start = pose.pose(pose.rotation([2.0, 0.1, 0.2]), [0.0, -0.7, 0.3])
    by_axis = np.stack([pose.about_axis([0, 0, 0], [0, 0, 1], -0.1 * i) @ start for i in range(COUNT)])
    slow = wander * np.column_stack([np.sin(0.1 * np.arange(COUNT)), np.cos(0.1 * np.arange(COUNT)), np.zeros(COUNT)])
    free = by_axis @ np.stack([pose.pose(np.eye(3), shift) for shift in slow + rng.normal(0, 3e-4, (COUNT, 3))])
    return free, by_axis


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("wander", [0.0, 0.004])
def test_wandering_is_no_jump(seed, wander):
    free, by_axis = poses(seed, wander)
    assert find_jump(free, by_axis, MIDDLE) is None


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("who", ["object", "camera"])
def test_a_push_is_found_with_its_frame_its_size_and_who(seed, who):
    free, by_axis = poses(seed, 0.002)
    push = pose.pose(np.eye(3), [0.008, 0.0, 0.0])
    for i in range(AT, COUNT):
        free[i] = push @ free[i] if who == "object" else free[i] @ push
    jump = find_jump(free, by_axis, MIDDLE)
    assert jump is not None and jump.who == who
    assert abs(jump.frame - AT) <= 1
    # noise of medians, and what the slow error does over the frames on either side
    assert jump.distance == pytest.approx(0.008, abs=0.0012)


@pytest.mark.parametrize("seed", range(5))
def test_an_object_off_the_axis_makes_no_jump_and_hides_none(seed):
    """Its middle goes round in the camera's frame, by the axis and as tracked alike."""
    free, by_axis = poses(seed)
    aside = MIDDLE + np.array([0.06, 0.0, 0.0])
    assert find_jump(free, by_axis, aside) is None
    free[AT:] = free[AT:] @ pose.pose(np.eye(3), [0.008, 0.0, 0.0])
    jump = find_jump(free, by_axis, aside)
    assert jump is not None and jump.who == "camera" and abs(jump.frame - AT) <= 1
    assert jump.distance == pytest.approx(0.008, abs=0.0012)


def test_frames_without_a_pose_do_not_hide_it():
    free, by_axis = poses(3)
    free[AT:] = pose.pose(np.eye(3), [0.0, 0.006, 0.0]) @ free[AT:]
    free[[5, 20, AT - 1]] = np.nan
    jump = find_jump(free, by_axis, MIDDLE)
    assert jump is not None and abs(jump.frame - AT) <= 1


def test_too_few_frames_say_nothing():
    free, by_axis = poses(0)
    few = 4 * BESIDE - 1
    free[few // 2 : few, :3, 3] += 0.02
    assert find_jump(free[:few], by_axis[:few], MIDDLE) is None
