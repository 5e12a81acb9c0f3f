"""The error of a trajectory is the one that evo prints."""

import numpy as np
import pytest
from evo.core import metrics
from evo.core.trajectory import PoseTrajectory3D

from fusion.geometry.pose import exp
from fusion.geometry.trajectory import Trajectory, trajectory_error


def trajectories(count=40, seed=0):
    """A wandering camera, and what a tracker in another frame makes of it."""
    random = np.random.default_rng(seed)
    poses = [np.eye(4)]
    for _ in range(count - 1):
        poses.append(poses[-1] @ exp(random.normal(0, 0.05, 6)))
    there = np.stack(poses)
    elsewhere = exp(np.array([0.4, -2.0, 1.1, 0.3, 0.2, -5.0]))
    here = np.stack([elsewhere @ T @ exp(random.normal(0, 0.01, 6)) for T in there])
    stamps = 10 + np.arange(count) / 30
    return Trajectory(stamps, here), Trajectory(stamps, there)


def by_evo(measured, reference):
    aligned = PoseTrajectory3D(poses_se3=list(measured.poses), timestamps=measured.timestamps)
    true = PoseTrajectory3D(poses_se3=list(reference.poses), timestamps=reference.timestamps)
    aligned.align(true, correct_scale=False)
    error = metrics.APE(metrics.PoseRelation.translation_part)
    error.process_data((true, aligned))
    return error.get_all_statistics()


@pytest.mark.parametrize("seed", range(4))
def test_every_number_is_evos(seed):
    measured, reference = trajectories(seed=seed)
    ours, theirs = trajectory_error(measured, reference), by_evo(measured, reference)
    for name in ("rmse", "mean", "median", "std", "min", "max"):
        assert getattr(ours, name) == pytest.approx(theirs[name], abs=1e-9)  # rounding of metres
    assert ours.frames == 40


def test_only_poses_of_the_same_time_count():
    measured, reference = trajectories()
    poses = measured.poses.copy()
    poses[5] = np.nan  # a rejected frame
    stamps = measured.timestamps + 0.004  # a reference at other times, 4 ms off
    stamps[30:] += 0.016  # and the rest too far off to belong to any
    some = np.r_[0:5, 6:30]
    kept = (Trajectory(t.timestamps[some], t.poses[some]) for t in (measured, reference))
    ours = trajectory_error(Trajectory(stamps, poses), reference)
    assert ours.frames == 29 and ours.rmse == pytest.approx(by_evo(*kept)["rmse"], abs=1e-9)


def test_a_mirrored_path_is_not_turned_into_its_image():
    measured, reference = trajectories()
    mirrored = measured.poses.copy()
    mirrored[:, 0, 3] *= -1
    measured = Trajectory(measured.timestamps, mirrored)
    assert trajectory_error(measured, reference).rmse == pytest.approx(by_evo(measured, reference)["rmse"], abs=1e-9)


def test_two_poses_say_nothing():
    measured, reference = trajectories(2)
    assert trajectory_error(measured, reference) is None
