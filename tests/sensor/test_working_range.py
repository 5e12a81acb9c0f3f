"""Between which depths a sensor gives values: none outside, and what is there counts as before."""

import json
from dataclasses import replace

import numpy as np
import pytest

from fusion.commands.main import main
from fusion.errors import SensorError
from fusion.geometry.camera import Camera
from fusion.recording.open import open_recording
from fusion.sensor.files.sensor_file import read_sensor, write_sensor
from fusion.sensor.presets import PRESETS, preset
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View
from fusion.sensor.working_range import ANY, WorkingRange

CAMERA = Camera(4, 1, 500.0, 500.0, 1.5, 0.0)
DEPTH = np.array([[0.3, 0.5, 9.0, 11.0]], np.float32)
LIMITED = replace(preset("kinect-v1"), effects=(), works=WorkingRange(0.4, 10.0, "made up"))


def test_what_lies_outside_has_no_value():
    rng = np.random.default_rng(0)
    assert np.isfinite(LIMITED.sample(DEPTH, CAMERA, None, rng)).tolist() == [[False, True, True, False]]
    assert LIMITED.dropout(DEPTH, View(CAMERA, DEPTH)).tolist() == [[1, 0, 0, 1]]
    assert np.isfinite(Sensor().sample(DEPTH, CAMERA, None, rng)).all()


def test_a_value_that_is_there_keeps_its_weight():
    limited, free = (replace(preset("kinect-v1"), works=works) for works in (LIMITED.works, ANY))
    assert np.array_equal(limited.weight(DEPTH, None, CAMERA), free.weight(DEPTH, None, CAMERA))


def test_it_goes_through_a_file(tmp_path):
    for works in (ANY, LIMITED.works, WorkingRange(0.2, source="x"), WorkingRange(0, 5.0)):
        write_sensor(tmp_path / "sensor.json", replace(LIMITED, works=works))
        assert read_sensor(tmp_path / "sensor.json").works == works
    content = json.loads((tmp_path / "sensor.json").read_text())
    (tmp_path / "sensor.json").write_text(json.dumps({**content, "range": {"nearest_m": 2.0, "farthest_m": 1.0}}))
    with pytest.raises(SensorError, match="2 to 1 m"):
        read_sensor(tmp_path / "sensor.json")


@pytest.mark.parametrize("name", sorted(set(PRESETS) - {"iphone-truedepth"}))
def test_every_preset_but_apples_front_camera_states_one_with_its_source(name):
    works = preset(name).works
    assert works != ANY and works.source


@pytest.mark.parametrize("distance", ["0.05", "20"])
def test_a_wall_outside_is_seen_by_no_pixel_and_said_in_a_line(tmp_path, capsys, distance):
    words = ["simulate", "wall", "--set", f"distance_m={distance}", "--set", "frames=1", "--sensor", "kinect-v1"]
    assert main([*words, "-o", str(tmp_path / "rec")]) == 0
    (line,) = (line for line in capsys.readouterr().err.splitlines() if "outside" in line)
    assert line.startswith("note: 100 % of what is seen") and "0.4 to 10 m" in line
    assert not np.isfinite(open_recording(tmp_path / "rec")[0].depth).any()
