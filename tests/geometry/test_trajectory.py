"""Poses are looked up by time; what has no pose is NaN."""

import numpy as np
import pytest

from fusion.geometry.pose import pose
from fusion.geometry.trajectory import Trajectory


def trajectory(stamps) -> Trajectory:
    """A camera that stands at x = its time stamp."""
    return Trajectory(np.array(stamps, float), np.array([pose(np.eye(3), [t, 0, 0]) for t in stamps]))


def test_own_stamps_give_own_poses():
    own = trajectory([0.0, 0.1, 0.2])
    np.testing.assert_array_equal(own.at(own.timestamps).poses, own.poses)
    assert own.valid.all()


@pytest.mark.parametrize("order", [[0, 1, 2, 3], [3, 1, 0, 2]])
def test_the_nearest_is_taken_whatever_the_order(order):
    stamps = np.array([0.0, 1.0, 2.0, 3.0])[order]
    asked = np.array([2.6, 0.4, 1.0, 2.99])
    np.testing.assert_array_equal(trajectory(stamps).at(asked, 0.5).centres[:, 0], [3.0, 0.0, 1.0, 3.0])


def test_too_far_in_time_is_nan():
    found = trajectory([0.0, 1.0]).at(np.array([-0.5, 0.015, 0.5, 0.99, 5.0]))
    np.testing.assert_array_equal(found.valid, [False, True, False, True, False])
    assert np.isnan(found.centres[~found.valid]).all()


def test_a_stamp_that_is_nan_has_no_pose():
    np.testing.assert_array_equal(trajectory([0.0, 1.0]).at(np.array([np.nan, 1.0])).valid, [False, True])


def test_one_pose_and_none():
    np.testing.assert_array_equal(trajectory([1.0]).at(np.array([1.01, 2.0])).valid, [True, False])
    empty = Trajectory(np.zeros(0), np.zeros((0, 4, 4)))
    assert len(empty) == 0
    assert not empty.at(np.array([0.0, 1.0])).valid.any()


def test_a_rejected_frame_is_not_valid():
    poses = trajectory([0.0, 1.0, 2.0]).poses
    poses[1] = np.nan
    np.testing.assert_array_equal(Trajectory(np.arange(3.0), poses).valid, [True, False, True])
