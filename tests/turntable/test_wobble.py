"""The rocking of an axis is what was planted; an object that stands askew does not rock."""

import numpy as np
import pytest

from fusion.geometry.pose import about_axis
from fusion.turntable.wobble import rocking

N = 48
STILL, UPRIGHT = np.zeros(N), np.eye(3)
TURNED = 2 * np.pi * np.arange(N) / 24
UP = np.array([0.0, -0.94, -0.342])
UP /= np.linalg.norm(UP)
SIGHT = np.array([0, 0, 1.0]) - UP[2] * UP
SIGHT /= np.linalg.norm(SIGHT)


def turn(axis, angle):
    return about_axis([0, 0, 0], axis, angle)[:3, :3]


def rotations(lean=None, planted=STILL, object_upright=UPRIGHT):
    """R_object_camera of an object turned about UP, then leaning about `lean` by the planted angles."""
    return np.stack(
        [
            (turn(UP if lean is None else lean, p) @ turn(UP, a) @ object_upright.T).T
            for a, p in zip(TURNED, planted, strict=True)
        ]
    )


@pytest.mark.parametrize(
    ("lean", "column", "sign"), [(np.cross(UP, SIGHT), 0, 1), (SIGHT, 1, -1)], ids=["away", "sideways"]
)
def test_a_planted_rocking_is_seen_in_its_direction(lean, column, sign):
    planted = np.radians(1.0) * np.sin(2 * TURNED)
    found = rocking(rotations(lean, planted), UP)
    # second order of a degree
    assert found.tilt[:, column] == pytest.approx(sign * planted, abs=3e-4)
    assert np.abs(found.tilt[:, 1 - column]).max() < 3e-4
    assert found.rms == pytest.approx(np.radians(1.0) / np.sqrt(2), rel=0.02)
    assert found.axis == pytest.approx(UP, abs=3e-4)


def test_an_object_askew_on_a_true_bearing_does_not_rock():
    askew = turn(SIGHT, np.radians(2.0))
    found = rocking(rotations(object_upright=askew), UP)
    assert found.rms < 1e-6 and found.axis == pytest.approx(UP, abs=1e-6)


def test_frames_without_a_pose_stay_out():
    R = rotations(SIGHT, np.radians(1.0) * np.sin(2 * TURNED))
    R[[3, 17]] = np.nan
    found = rocking(R, UP)
    assert np.flatnonzero(np.isnan(found.tilt[:, 0])).tolist() == [3, 17] and np.isfinite(found.rms)
    assert np.isnan(rocking(np.full((4, 3, 3), np.nan), UP).rms)


def test_a_single_pose_does_not_rock():
    assert rocking(np.eye(3)[None], np.array([0, 0, 1.0])).rms < 1e-9
