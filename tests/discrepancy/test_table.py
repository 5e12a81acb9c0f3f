"""Turntable recordings: the axis from poses and log, the velocity of what turns, and the rig's errors named by it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fusion.discrepancy.observe.scene.motion import twists_of
from fusion.discrepancy.observe.scene.table import table_of
from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import about_axis, inverse
from fusion.geometry.trajectory import Trajectory
from fusion.recording.recording import Recording

POINT, DIRECTION = (0.1, -0.2, 0.3), (0.1, 0.2, 1.0)


def turning(degrees: np.ndarray, rate_hz: float = 5.0, **scene) -> Recording:
    """A camera seen from an object that turns by logged angles."""
    stamps = 10.0 + np.arange(len(degrees)) / rate_hz
    at_first = np.eye(4)
    at_first[:3, 3] = 0.4, 0.1, -0.8
    poses = np.array([inverse(about_axis(POINT, DIRECTION, np.deg2rad(a))) @ at_first for a in degrees])
    camera = Camera(32, 24, 30.0, 30.0, 15.5, 11.5, principle="itof")
    log = {"timestamp": stamps, "turntable_deg": np.asarray(degrees, float)}

    def nothing(index: int):
        raise IndexError(index)

    return Recording(Path("rec"), "native", camera, stamps, nothing, Trajectory(stamps, poses), log, scene)


@pytest.mark.parametrize("step", [7.0, -11.0, 90.0])
def test_the_axis_follows_from_poses_and_log(step):
    table = table_of(turning(40 + step * np.arange(12)))
    assert table is not None
    axis = np.array(DIRECTION) / np.linalg.norm(DIRECTION)
    # rounding of double numbers
    assert table.direction == pytest.approx(axis, abs=1e-9)
    assert np.linalg.norm(np.cross(table.point - np.array(POINT), axis)) < 1e-9


def test_what_is_stated_of_the_axis_counts():
    about = {"turntable": {"axis_point": [0, 0, 1], "axis_direction": [0, 0, 2]}, "continuous": False}
    stepped = turning(10.0 * np.arange(9), trajectory=about)
    table = table_of(stepped)
    assert table is not None and table.direction.tolist() == [0, 0, 1] and not twists_of(stepped).any()
    with pytest.raises(RecordingError):
        table_of(turning(10.0 * np.arange(9), trajectory={"turntable": {"axis_point": [0], "axis_direction": "up"}}))


def test_a_table_that_turns_while_frames_are_taken_has_a_rate():
    recording = turning(9.0 * np.arange(10))
    table = table_of(recording)
    assert table is not None
    # the camera goes round backwards, 9 deg in 0.2 s
    spin = -np.deg2rad(9.0 * 5.0) * table.direction
    assert twists_of(recording)[4][:3] == pytest.approx(spin, abs=1e-9)
    assert not twists_of(turning(9.0 * np.arange(10), rate_hz=0.5)).any()


def test_a_camera_in_a_hand_has_a_rate_and_needs_no_table():
    recording = turning(9.0 * np.arange(10))
    in_a_hand = replace(recording, telemetry={})
    assert table_of(in_a_hand) is None
    assert twists_of(in_a_hand) == pytest.approx(twists_of(recording))
    assert recording.poses is not None
    still = Trajectory(recording.timestamps, np.repeat(recording.poses.poses[:1], 10, axis=0))
    assert not twists_of(replace(in_a_hand, poses=still)).any()
    assert not twists_of(replace(in_a_hand, poses=None)).any()


def test_no_log_or_poses_of_the_room_are_no_table():
    recording = turning(9.0 * np.arange(10))
    assert table_of(replace(recording, telemetry={})) is None
    assert recording.poses is not None
    still = np.repeat(recording.poses.poses[:1], 10, axis=0)
    assert table_of(replace(recording, poses=Trajectory(recording.timestamps, still))) is None
