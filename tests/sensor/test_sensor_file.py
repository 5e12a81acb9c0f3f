"""sensor.json: read, written, and what is wrong with it."""

import json

import numpy as np
import pytest

from fusion.errors import SensorError
from fusion.geometry.camera import Camera
from fusion.sensor.catalogue import KNOWN
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.file import read_sensor, write_sensor
from fusion.sensor.presets import PRESETS, preset
from fusion.sensor.sensor import Sensor


def written(folder, effects, **more):
    path = folder / "sensor.json"
    path.write_text(json.dumps({"format": "fusion-sensor/1", "name": "n", "effects": effects, **more}))
    return path


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_survives_the_file(name, tmp_path):
    write_sensor(tmp_path / "s.json", preset(name))
    assert read_sensor(tmp_path / "s.json") == preset(name) == read_sensor(name)


def test_a_map_survives_the_file(tmp_path):
    offset = np.linspace(0, 0.01, 48).reshape(6, 8)
    write_sensor(
        tmp_path / "s.json", Sensor("m", effects=(DepthOffset(offset),), std={("depth_offset", "offset"): 1e-3})
    )
    sensor = read_sensor(tmp_path / "s.json")
    assert np.array_equal(sensor.effects[0].offset, offset)
    assert sensor.std == {("depth_offset", "offset"): 1e-3}
    wall = np.full((6, 8), 1.0)
    assert np.allclose(sensor.correct(wall + offset, Camera(8, 6, 10, 10, 3.5, 2.5)), wall, atol=1e-6)
    with pytest.raises(SensorError, match="does not fit the image"):
        sensor.correct(np.ones((4, 4)), Camera(4, 4, 10, 10, 1.5, 1.5))


@pytest.mark.parametrize("name", sorted(KNOWN))
def test_every_known_name_is_accepted(name, tmp_path):
    sensor = read_sensor(written(tmp_path, [{"effect": name, "parameters": {}}]))
    computed = sensor.effect(name) is not None
    assert computed or any(text.startswith(name) for text in sensor.left_out)
    write_sensor(tmp_path / "again.json", sensor)
    assert read_sensor(tmp_path / "again.json").kept == sensor.kept


def test_the_order_in_the_file_has_no_meaning(tmp_path):
    entries = [
        {"effect": "depth_quantization", "parameters": {"step": {"value": 0.001, "unit": "m"}}},
        {"effect": "depth_scale", "parameters": {"scale": {"value": 0.01, "unit": "1", "std": 0.001}}},
    ]
    sensor = read_sensor(written(tmp_path, entries))
    assert [effect.name for effect in sensor.effects] == ["depth_scale", "depth_quantization"]
    assert not sensor.warnings  # step_px is another way to say it, not a missing value


def test_a_missing_parameter_is_neutral_and_said(tmp_path):
    sensor = read_sensor(written(tmp_path, [{"effect": "axial_noise", "parameters": {"c0": {"value": 0.002}}}]))
    assert sensor.effects[0].c1 == 0 and any("c1" in text for text in sensor.warnings)


def test_the_projector_of_the_file_is_used(tmp_path):
    shadow = {"effect": "projector_shadow", "parameters": {"baseline": {"value": 0.05, "unit": "m"}}}
    assert read_sensor(written(tmp_path, [shadow])).baseline == 0.05
    assert read_sensor(written(tmp_path, [])).baseline == 0.075


BROKEN = {
    "unknown effect": [{"effect": "wiggle"}],
    "unknown parameter": [{"effect": "depth_scale", "parameters": {"factor": {"value": 1}}}],
    "wrong unit": [{"effect": "depth_offset", "parameters": {"offset": {"value": 3, "unit": "mm"}}}],
    "out of bounds": [{"effect": "depth_offset", "parameters": {"offset": {"value": 3}}}],
    "has no value": [{"effect": "depth_offset", "parameters": {"offset": {}}}],
    "given twice": [{"effect": "depth_offset"}, {"effect": "depth_offset"}],
    "has 2 values": [{"effect": "depth_offset", "parameters": {"offset": {"value": [0.1, 0.2]}}}],
    "cannot be read": [{"effect": "depth_offset", "parameters": {"offset": {"value": "gone.npy"}}}],
    "not finite": [{"effect": "depth_offset", "parameters": {"offset": {"value": float("nan")}}}],
    "is negative": [{"effect": "depth_offset", "parameters": {"offset": {"value": 0, "std": -1}}}],
    "no object": [{"effect": "depth_offset", "parameters": [1]}],
    "no list of effects": {"effect": "depth_offset"},
}


@pytest.mark.parametrize("problem", BROKEN)
def test_a_wrong_entry_is_one_clear_line(problem, tmp_path):
    path = written(tmp_path, BROKEN[problem])
    with pytest.raises(SensorError, match=problem) as caught:
        read_sensor(path)
    assert "\n" not in str(caught.value) and "sensor.json" in str(caught.value)


@pytest.mark.parametrize(
    "content", [b"", b"{", b"[]", b"null", b"\xff\xfe\x00", b'{"format": "fusion-sensor/9"}', b"[" * 100000]
)
def test_a_broken_file_is_one_clear_line(content, tmp_path):
    (tmp_path / "s.json").write_bytes(content)
    with pytest.raises(SensorError):
        read_sensor(tmp_path / "s.json")


@pytest.mark.parametrize("more", [{"principle": "sonar"}, {"baseline_m": 75}, {"baseline_m": "wide"}])
def test_wrong_fields_are_one_clear_line(more, tmp_path):
    with pytest.raises(SensorError):
        read_sensor(written(tmp_path, [], **more))


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(SensorError, match="not there"):
        read_sensor(tmp_path / "gone.json")
