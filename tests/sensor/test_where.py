"""An effect confined by bounds acts inside them only, in every use of the model, and files keep the bounds."""

import json
from dataclasses import replace

import numpy as np
import pytest

from fusion.errors import SensorError
from fusion.geometry.camera import Camera
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.files.sensor_file import read_sensor, write_sensor
from fusion.sensor.sensor import Sensor
from fusion.sensor.where import Bound

CAMERA = Camera(40, 30, 35.0, 35.0, 19.5, 14.5)
DEPTH = np.linspace(0.5, 3.0, 1200).reshape(30, 40)
FAR = DepthOffset(offset=0.01, where=(Bound("depth", 2.0), Bound("u", high=19.5)))


def test_it_acts_inside_only_and_is_undone_there():
    sensor = Sensor(effects=(FAR,))
    measured = sensor.predict(DEPTH, CAMERA)
    inside = (DEPTH >= 2.0) & (np.arange(40) < 20)[None]
    np.testing.assert_allclose(measured - DEPTH, np.where(inside, 0.01, 0.0), atol=1e-12)
    # at the edge itself the measured depth does not tell on which side the truth was
    clear = np.abs(DEPTH - 2.0) > 0.011
    np.testing.assert_allclose(sensor.correct(measured, CAMERA)[clear], DEPTH[clear], atol=1e-6)


def test_files_keep_where(tmp_path):
    write_sensor(tmp_path / "sensor.json", Sensor(effects=(FAR,)))
    assert read_sensor(tmp_path / "sensor.json").effects == (FAR,)
    assert replace(FAR, where=()) != FAR


@pytest.mark.parametrize("where", [3, [3], [{"variable": "mood", "low": 0, "high": 1}], [{"variable": "u"}]])
def test_a_broken_where_is_refused_in_one_line(tmp_path, where):
    write_sensor(tmp_path / "sensor.json", Sensor(effects=(FAR,)))
    content = json.loads((tmp_path / "sensor.json").read_text())
    content["effects"][0]["where"] = where
    (tmp_path / "sensor.json").write_text(json.dumps(content))
    with pytest.raises(SensorError):
        read_sensor(tmp_path / "sensor.json")
