"""The simulated table: its poses are turns about its axis, its errors are those that were asked for."""

import numpy as np
import pytest

from fusion.errors import FusionError
from fusion.geometry.pose import about_axis, angle, inverse, is_rigid, pose, transform
from fusion.simulation.scene.turntable import Turntable, TurntableErrors

AXIS = {"axis_point": (0.1, -0.2, 0.3), "axis_direction": (0.2, -0.1, 2.0)}


@pytest.mark.parametrize("step", [6.0, -20.0])
def test_poses_are_turns_about_the_axis(step):
    table = Turntable(**AXIS, degrees_per_frame=step, frames=9)
    turned = table.true_deg(np.random.default_rng(0))
    assert np.array_equal(turned, table.commanded_deg())
    T_world_camera = pose(np.eye(3), [0, 0, -1])
    for k, T in enumerate(table.T_object_camera(T_world_camera, turned)):
        assert is_rigid(T)
        expected = (
            inverse(about_axis(AXIS["axis_point"], AXIS["axis_direction"], np.deg2rad(step * k))) @ T_world_camera
        )
        assert np.allclose(T, expected)
    assert np.allclose(table.T_world_object(turned)[:, :3] @ [*AXIS["axis_point"], 1], AXIS["axis_point"])


def test_a_slip_stays_and_uneven_steps_add_up():
    errors = TurntableErrors(uneven_sd_deg=0.2, slip_frame=50, slip_deg=3.0)
    table = Turntable(degrees_per_frame=-2.0, frames=2000, errors=errors)
    excess = table.true_deg(np.random.default_rng(3)) - table.commanded_deg()
    steps = np.diff(excess)
    assert excess[0] == 0
    assert steps[49] == pytest.approx(-3.0, abs=1.0)  # five standard deviations of a step
    rest = np.delete(steps, 49)
    assert rest.std() == pytest.approx(0.2, abs=4 * 0.2 / np.sqrt(2 * len(rest)))  # four standard errors


def test_wobble_rocks_the_axis_by_its_amplitude():
    table = Turntable(frames=73, degrees_per_frame=5.0, errors=TurntableErrors(wobble_deg=0.5))
    poses = table.T_world_object(table.commanded_deg())
    tilt = np.rad2deg(np.arccos(np.clip(poses[:, 2, 2], -1, 1)))
    assert tilt.max() == pytest.approx(0.5, abs=0.01)  # sampled every 5 degrees
    assert angle(poses[0]) == pytest.approx(0.0, abs=1e-9)
    assert np.allclose([transform(T, np.zeros(3)) for T in poses], 0, atol=1e-12)


@pytest.mark.parametrize("wrong", [{"frames": 0}, {"axis_direction": (0, 0, 0)}, {"axis_point": (0, 0, np.nan)}])
def test_a_table_that_cannot_be_is_refused(wrong):
    with pytest.raises(FusionError):
        Turntable(**wrong)
