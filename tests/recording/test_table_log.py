"""A turntable's log in radians is mentioned before anything is made of it."""

from dataclasses import replace

import numpy as np
import pytest
import synthetic

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.recording.checks import table_log
from fusion.recording.checks.table_log import check_table_log
from fusion.recording.looking.sample import draw
from fusion.recording.open import open_recording
from fusion.recording.writing.write import write_recording


@pytest.fixture
def folder(tmp_path):
    write_recording(tmp_path / "r", synthetic.CAMERA, synthetic.frames(12))
    return tmp_path / "r"


def told(folder, angles: np.ndarray) -> list[str]:
    recording = open_recording(folder)
    telemetry = {"timestamp": recording.timestamps, "turntable_deg": angles}
    return [finding.seen for finding in check_table_log(draw(replace(recording, telemetry=telemetry), 4, 4))]


@pytest.mark.parametrize("turns", [1, 2, 3, -1])
@pytest.mark.parametrize("end", [11, 12])  # the last frame is the first again, or one step before it
def test_whole_turns_in_radians(folder, turns, end):
    assert "whole turns in radians" in told(folder, 2 * np.pi * turns * np.arange(12) / end)[0]


def test_degrees_and_a_table_that_stands_are_left_in_peace(folder):
    for total in (360.0, 90.0, 30.0, 0.0, 0.1):
        assert told(folder, np.linspace(0, total, 12)) == []


def test_a_part_of_a_turn_where_something_turns(folder, monkeypatch):
    quarter = np.linspace(0, np.pi / 2, 12)
    assert told(folder, quarter) == []  # the camera moves
    monkeypatch.setattr(table_log, "turns_before_a_still_camera", lambda sample: True)
    assert "1.57 in all" in told(folder, quarter)[0]


def test_frames_that_would_take_all_memory_are_not_begun(folder):
    with pytest.raises(RecordingError, match=r"65535 x 65535 pixels is too large.*--allow-gb"):
        open_recording(folder, Camera(65535, 65535, 500.0, 500.0, 300.0, 200.0))
