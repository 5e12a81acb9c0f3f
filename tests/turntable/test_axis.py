"""The axis of a turntable: rigid turns and small changes."""

import numpy as np
import pytest

from fusion.geometry import pose
from fusion.turntable.axis import Axis


def some_axis(rng):
    direction = rng.standard_normal(3)
    return Axis(rng.uniform(-0.3, 0.3, 3) + np.array([0, 0, 0.7]), direction / np.linalg.norm(direction))


def test_a_turn_is_rigid_adds_up_and_leaves_the_axis_alone():
    axis = some_axis(np.random.default_rng(1))
    assert axis.turn(0.3) @ axis.turn(0.5) == pytest.approx(axis.turn(0.8), abs=1e-12)
    assert pose.is_rigid(axis.turn(2.0))
    assert axis.turns(np.array([0.0, 0.3, 2.0])) == pytest.approx(np.stack([axis.turn(a) for a in (0.0, 0.3, 2.0)]))
    on_it = axis.point + np.outer([-1.0, 0.0, 2.0], axis.direction)
    assert pose.transform(axis.turn(2.0), on_it) == pytest.approx(on_it, abs=1e-12)


def test_a_turn_is_right_handed():
    quarter = Axis(np.zeros(3), np.array([0.0, 0.0, 1.0])).turn(np.pi / 2)
    assert pose.transform(quarter, np.array([1.0, 0, 0])) == pytest.approx([0, 1, 0], abs=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_across_is_perpendicular_and_moved_does_what_it_says(seed):
    axis = some_axis(np.random.default_rng(seed))
    frame = np.vstack([axis.across(), axis.direction])
    assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-12)
    moved = axis.moved(np.array([0.01, -0.02, 0.003, 0.004]))
    assert np.linalg.norm(moved.direction) == pytest.approx(1, abs=1e-12)
    tilt = np.arccos(axis.direction @ moved.direction)
    assert tilt == pytest.approx(np.hypot(0.01, 0.02), rel=1e-6)
    assert axis.across() @ (moved.point - axis.point) == pytest.approx([0.003, 0.004], abs=1e-12)
    still = axis.moved(np.zeros(4))
    assert still.point == pytest.approx(axis.point) and still.direction == pytest.approx(axis.direction)


def test_the_point_slides_to_where_it_is_nearest():
    axis = some_axis(np.random.default_rng(2))
    target = np.array([0.1, 0.2, 0.9])
    near = axis.nearest_to(target)
    assert (target - near.point) @ axis.direction == pytest.approx(0, abs=1e-12)
    assert axis.distance(near.point[None])[0] == pytest.approx([0], abs=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_the_object_frame_stands_on_the_axis_and_looks_at_the_camera(seed):
    axis = some_axis(np.random.default_rng(seed))
    T = axis.object_frame()
    assert pose.is_rigid(T)
    assert pose.transform(T, axis.point) == pytest.approx(np.zeros(3), abs=1e-12)
    assert T[:3, :3] @ axis.direction == pytest.approx([0, 0, 1], abs=1e-12)
    camera = T[:3, 3]
    assert camera[1] == pytest.approx(0, abs=1e-12) and camera[0] > 0


def test_a_camera_on_the_axis_still_gets_a_frame():
    assert pose.is_rigid(Axis(np.array([0, 0, 0.8]), np.array([0, 0, -1.0])).object_frame())
