"""The circle through the camera's centres: exact on an arc, and only centres move."""

import numpy as np
import pytest

from fusion.errors import TrackingError
from fusion.geometry import pose
from fusion.geometry.trajectory import Trajectory
from fusion.turntable.circle import fit_circle, onto_circle

TILT = pose.exp([0.4, -0.3, 0.2, 0.1, 0.2, 0.8])


def arc(degrees, radius=0.7):
    a = np.deg2rad(degrees)
    return pose.transform(TILT, np.column_stack([radius * np.cos(a), radius * np.sin(a), np.zeros(len(a))]))


@pytest.mark.parametrize("degrees", [np.arange(0, 360, 15), np.arange(0, 60, 4), np.array([0, 40, 100])])
def test_an_arc_gives_its_circle(degrees):
    circle = fit_circle(arc(degrees))
    # the fit stops at steps of 1e-9 m; a short arc makes the centre some hundred times less sure than its points
    assert circle.radius == pytest.approx(0.7, abs=1e-7)
    assert circle.centre == pytest.approx(TILT[:3, 3], abs=1e-7)
    assert abs(circle.normal @ TILT[:3, 2]) == pytest.approx(1, abs=1e-9)
    assert circle.radial_rms < 1e-8 and circle.axial_rms < 1e-8


def test_the_deviations_are_told_apart():
    points = arc(np.arange(0, 360, 10))
    up = TILT[:3, 2] * 0.002 * np.resize([1, -1], len(points))[:, None]
    out = (points - TILT[:3, 3]) / 0.7 * 0.003 * np.resize([1, 1, -1, -1], len(points))[:, None]
    circle = fit_circle(points + up + out)
    # the patterns have no part that a circle could follow
    assert circle.axial_rms == pytest.approx(0.002, rel=0.02)
    assert circle.radial_rms == pytest.approx(0.003, rel=0.02)


def test_angles_and_points_are_inverse():
    circle = fit_circle(arc(np.arange(0, 300, 20)))
    angles = np.array([-2.0, 0.1, 1.5])
    assert circle.angles(circle.at(angles)) == pytest.approx(angles, abs=1e-9)


@pytest.mark.parametrize("points", [np.outer(np.arange(5.0), [1, 2, 3]), np.zeros((5, 3)), arc(np.array([0.0, 20.0]))])
def test_no_circle_is_told(points):
    with pytest.raises(TrackingError, match="no circle"):
        fit_circle(points)


def shaken(n=24, seed=0):
    rng = np.random.default_rng(seed)
    poses = np.tile(np.eye(4), (n, 1, 1))
    poses[:, :3, 3] = arc(np.arange(n) * 15.0) + rng.normal(0, 0.002, (n, 3))
    for T in poses:
        T[:3, :3] = pose.exp([*rng.uniform(-1, 1, 3), 0, 0, 0])[:3, :3]
    poses[5] = np.nan
    return Trajectory(np.arange(float(n)), poses)


def told(sign, n=24):
    return sign * np.deg2rad(np.arange(n) * 15.0) + 0.4


@pytest.mark.parametrize("commanded", [None, told(1), told(-1)])
def test_only_centres_move_onto_the_circle(commanded):
    raw = shaken()
    flat, circle = onto_circle(raw, commanded)
    keep = raw.valid
    assert (flat.valid == keep).all() and not flat.valid[5]
    assert np.array_equal(flat.poses[keep][:, :3, :3], raw.poses[keep][:, :3, :3])
    again = fit_circle(flat.centres[keep])
    assert again.radial_rms < 1e-8 and again.axial_rms < 1e-8
    assert again.radius == pytest.approx(circle.radius, abs=1e-7)
    # noise of 2 mm in each direction; 5 mm is 2.5 sigma across two directions, 12 mm never happens
    assert np.linalg.norm(flat.centres[keep] - raw.centres[keep], axis=1).max() < 0.012
    if commanded is not None:
        assert np.abs(np.diff(np.unwrap(circle.angles(flat.centres[keep])))[6:]) == pytest.approx(np.deg2rad(15))
