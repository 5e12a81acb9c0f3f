"""The quick look before a scan: sure of what would fail, silent on what is well."""

import re
from dataclasses import replace

import numpy as np
import pytest
from synthetic import depth as room
from synthetic import poses

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import about_axis
from fusion.geometry.trajectory import Trajectory
from fusion.recording.checks.poses import check_poses
from fusion.recording.checks.stillness import check_camera_moves, check_object_turns
from fusion.recording.looking.doctor import quick_look, refuse_if_certain
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame, Recording

CAMERA = Camera(160, 120, 130.0, 130.0, 79.5, 59.5, depth_scale=5000.0)
COUNT = 12
BOTH = (check_camera_moves, check_object_turns)


def recording(tmp_path, depth_of, log=None, count=COUNT) -> Recording:
    """A recording in memory whose frame i shows `depth_of(i)`."""
    stamps = np.arange(count) / 10
    telemetry = {} if log is None else {"timestamp": stamps, "turntable_deg": np.asarray(log, float)}
    return Recording(
        tmp_path, "native", CAMERA, stamps, lambda i: Frame(i, i / 10, depth_of(i)), telemetry=telemetry
    )  # fmt: skip


def corner(i):
    """Two walls and a floor, from a camera that stands still."""
    across, down = about_axis([0, 0, 0], [0, 1, 0], 0.6), about_axis([0, 0, 0], [1, 0, 0], -0.4)
    return room(across @ down, CAMERA, seed=i)


def slab(depth, i):
    """With a slab that gets wide and narrow, as a box on a turntable does."""
    half = int(22 + 14 * np.cos(2 * np.pi * i / COUNT))
    depth[40:90, 80 - half : 80 + half] = 0.5
    return depth


def turning(i):
    return slab(corner(i), i)


def before_a_wall(i):
    wall = 1.5 + np.random.default_rng(i).normal(0, 0.001, CAMERA.shape)
    return slab(wall.astype(np.float32), i)


def alone(i):
    """Nothing but the turning thing is seen, as with a background out of reach."""
    return slab(np.full(CAMERA.shape, np.nan, np.float32), i)


def moving(i):
    return room(poses(COUNT)[i], CAMERA, seed=i)


def told(recording, check, **settings):
    return [(f.severity, f.seen) for f in quick_look(recording, (check,), **settings)]


@pytest.mark.parametrize(
    ("depth_of", "for_moving", "for_turning"),
    [
        (turning, "error", None),
        (before_a_wall, "warning", None),  # a camera that slides along the wall would see the same
        (alone, None, None),
        (moving, None, "error"),
        (corner, "warning", "warning"),
    ],
    ids=["turntable", "turntable before a wall", "object alone", "moving camera", "nothing moves"],
)
def test_who_moves(tmp_path, depth_of, for_moving, for_turning):
    for check, expected in zip(BOTH, (for_moving, for_turning), strict=True):
        found = [severity for severity, _ in told(recording(tmp_path, depth_of), check)]
        assert found == ([expected] if expected else [])


def test_a_log_makes_it_certain(tmp_path):
    log = 30.0 * np.arange(COUNT)
    assert told(recording(tmp_path, before_a_wall, log), check_camera_moves)[0][0] == "error"
    assert told(recording(tmp_path, alone, log), check_camera_moves)[0][0] == "warning"


def test_a_background_beyond_the_largest_depth_does_not_count(tmp_path):
    assert told(recording(tmp_path, turning), check_camera_moves, max_depth=0.6) == []


def test_too_few_frames_tell_nothing(tmp_path):
    assert quick_look(recording(tmp_path, turning, count=3), BOTH) == []
    assert quick_look(recording(tmp_path, turning, count=0), BOTH) == []


def test_the_worst_is_told_first_and_ends_the_work_unless_forced(tmp_path):
    in_millimetres = recording(tmp_path, lambda i: 1000 * moving(i))
    findings = quick_look(in_millimetres, BOTH)
    assert findings[0].check == "depth" and findings[0].severity == "error"
    with pytest.raises(RecordingError, match=r"median depth .* not what such cameras measure.*--force"):
        refuse_if_certain(findings, in_millimetres)
    assert refuse_if_certain(findings, in_millimetres, force=True)[0][0] == "bad"


def test_a_range_is_told(tmp_path):
    long = np.sqrt(1 + (CAMERA.rays() ** 2).sum(axis=-1)).astype(np.float32)
    findings = quick_look(recording(tmp_path, lambda i: moving(i) * long))
    assert [(f.check, f.severity) for f in findings] == [("range or z", "error")]
    assert quick_look(recording(tmp_path, moving)) == []


MOVING_CAMERA = ["tum_fr1_rpy", "robot_arm_boxes"]
TURNTABLE = ["kleenex_turntable", "custard_box"]


@pytest.mark.real
@pytest.mark.parametrize("name", [*MOVING_CAMERA, *TURNTABLE, "ycbv_0000"])
def test_real_recordings(shared, name):
    real = open_recording(shared / "data" / name, "tum-fr1" if name == "tum_fr1_rpy" else None)
    turns = [f.severity for f in quick_look(real, (check_camera_moves,))]
    assert bool(turns) == (name not in MOVING_CAMERA)  # of the others one stands still and two show a turntable
    assert ("error" in turns) == (name in TURNTABLE)
    moves = [f.severity for f in quick_look(real, (check_object_turns,))]
    assert moves == (["error"] if name in MOVING_CAMERA else [])


@pytest.mark.real
@pytest.mark.parametrize("name", ["turntable_v1_statue", "turntable_v2_bricks", "turntable_v2_statue"])
def test_no_false_alarm_on_turntables(shared, name):
    real = open_recording(shared / "challenges/turntable" / name / "scan")
    assert quick_look(real, (check_object_turns,)) == []
    assert quick_look(replace(real, telemetry={}), (check_camera_moves,)) == []


@pytest.mark.parametrize("factor", [1.0, 1.25, 0.8])
def test_a_scale_that_stated_poses_contradict_is_told(tmp_path, factor):
    """Depth that reads so many times too short, as where a file says nothing of its unit."""
    made = recording(tmp_path, lambda i: moving(i) / np.float32(factor))
    posed = replace(made, poses=Trajectory(made.timestamps, poses(COUNT)))
    found = told(posed, check_poses)
    wrong = [re.search(r"with depth_scale (\d+) or about", seen) for _, seen in found]
    scales = [float(match[1]) for match in wrong if match]
    assert "error" not in [severity for severity, _ in found]
    assert scales == ([] if factor == 1 else [pytest.approx(CAMERA.depth_scale / factor, rel=0.06)])


def test_poses_that_go_on_take_the_certainty_from_a_camera_that_seems_to_stand(tmp_path):
    made = recording(tmp_path, turning)
    along = np.tile(np.eye(4), (COUNT, 1, 1))
    along[:, 0, 3] = 0.002 * np.arange(COUNT)
    carried = replace(made, poses=Trajectory(made.timestamps, along))
    assert [severity for severity, _ in told(made, check_camera_moves)] == ["error"]
    assert [severity for severity, _ in told(carried, check_camera_moves)] == ["warning"]
