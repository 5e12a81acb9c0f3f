"""The same recording twice is refused, whatever its files are called; so are frames that nobody placed."""

from dataclasses import replace
from pathlib import Path
from shutil import copytree

import numpy as np
import pytest

import fusion
from fusion.commands.camera.explain import left_out
from fusion.errors import RecordingError
from fusion.recording.looking.copies import print_of, refuse_copies
from fusion.simulation.scenes.panel import wall

CAMERA = replace(fusion.find_camera("kinect-v1"), width=80, height=60, fx=73.0, fy=73.0, cx=39.5, cy=29.5)


def made(folder, seed):
    """A recording of a wall, small."""
    sensor = fusion.read_sensor("kinect-v1")
    simulation = fusion.simulate(replace(wall(frames=7), camera=CAMERA), sensor, seed)
    fusion.write_simulation(folder, simulation)
    return fusion.open_recording(folder)


def test_a_copy_is_refused_under_any_name_and_in_any_part(tmp_path):
    one, other = made(tmp_path / "one", 1), made(tmp_path / "other", 2)
    sensor = fusion.read_sensor("kinect-v1")
    copytree(tmp_path / "one", tmp_path / "copy")
    for twice in ([one, one], [one, other, fusion.open_recording(tmp_path / "copy")]):
        with pytest.raises(RecordingError, match=r"given twice.*7 frames of 7 that are those of .*one"):
            fusion.explain(twice, sensor)


def test_one_shared_frame_is_enough():
    shared = (Path("a"), frozenset([b"1", b"2"])), (Path("b"), frozenset([b"3", b"2"]))
    with pytest.raises(RecordingError, match="in b; found 1 frames of 2"):
        refuse_copies(shared)
    refuse_copies([shared[0], (Path("c"), frozenset([b"3"])), (Path("d"), frozenset())])


def test_a_frame_with_hardly_a_value_tells_nothing():
    depth = np.full((20, 20), np.nan, np.float32)
    depth[0] = 1.0
    assert print_of(depth) == b""
    assert print_of(np.ones((20, 20), np.float32)) == print_of(np.ones((20, 20), np.float32)) != b""


def test_frames_at_the_times_of_no_pose_are_refused_in_one_line(tmp_path):
    one = made(tmp_path / "one", 1)
    late = replace(one, timestamps=one.timestamps + 100)
    with pytest.raises(RecordingError, match=r"no frame is at the time of a pose.*check the time stamps"):
        fusion.explain([late], fusion.read_sensor("kinect-v1"))


def test_some_frames_at_the_times_of_no_pose_are_named(tmp_path):
    one = made(tmp_path / "one", 1)
    assert left_out(one) == []
    late = replace(one, timestamps=one.timestamps + 100 * (np.arange(7) > 4), warnings=("sorted",))
    assert left_out(late) == ["sorted", "2 of 7 frames have no stated pose at their time: left out"]


@pytest.mark.parametrize("calibrate", [fusion.calibrate_depth, fusion.calibrate_noise])
def test_a_calibration_refuses_a_recording_that_is_given_twice(tmp_path, calibrate):
    one, other = made(tmp_path / "one", 1), made(tmp_path / "other", 2)
    copytree(tmp_path / "one", tmp_path / "copy")
    with pytest.raises(RecordingError, match="given twice"):
        calibrate([one, other, fusion.open_recording(tmp_path / "copy")])
