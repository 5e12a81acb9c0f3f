"""sensor.json: read, written, and what is wrong with it."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from fusion.errors import SensorError
from fusion.geometry.camera import Camera
from fusion.sensor.catalogue import KNOWN
from fusion.sensor.effects import EFFECTS
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.effects.readout.tabulated import Tabulated
from fusion.sensor.effects.readout.temperature_drift import TemperatureDrift
from fusion.sensor.effects.triangulation.disparity_distortion import DisparityDistortion
from fusion.sensor.effects.triangulation.vertical_banding import VerticalBanding
from fusion.sensor.files.sensor_file import read_sensor, write_sensor
from fusion.sensor.parameter import parameters
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


@pytest.mark.parametrize("kind", EFFECTS, ids=lambda kind: kind.name)
def test_every_effect_survives_the_file(kind, tmp_path):
    first = {}
    for about in parameters(kind).values():
        first.setdefault(about.label, about)  # a file holds one of two units
    values = {p.name: [p.typical, p.high] if p.kind == "list" else p.typical for p in first.values()}
    sensor = Sensor("s", effects=(kind(**values),), std={(kind.name, p.name): 0.1 for p in first.values()})
    write_sensor(tmp_path / "s.json", sensor)
    again = read_sensor(tmp_path / "s.json")
    assert again == sensor and hash(again.effects) == hash(sensor.effects)
    assert again != replace(sensor, effects=(kind(),))


def test_a_map_that_another_file_names_stays_as_it_is(tmp_path):
    """Also where a stop comes between the map and the file: the older file names the older map."""

    def model(size: float) -> Sensor:
        return Sensor("s", effects=(DisparityDistortion(map=np.full((6, 8), size)),))

    for size in (0.1, 0.2, 0.1, 0.2):
        write_sensor(tmp_path / "s.json", model(size))
        (tmp_path / "s.json").rename(tmp_path / f"kept_{size}.json")
    for size in (0.1, 0.2):
        assert read_sensor(tmp_path / f"kept_{size}.json") == model(size)
    assert len(list(tmp_path.glob("*.npy"))) == 2


def test_lists_and_tables_survive_the_file(tmp_path):
    effects = (
        VerticalBanding(columns=[100.0, 200.5], steps=[0.1, -0.05]),
        DisparityDistortion(map=np.linspace(-1, 1, 48).reshape(6, 8)),
        Tabulated(("time", "depth"), ((0, 100, 200), (0.5, 4)), np.arange(6.0).reshape(3, 2) / 100),
    )
    std = {("vertical_banding", "steps"): (0.01, 0.02), ("vertical_banding", "columns"): 1.0}
    sensor = Sensor("lists", "structured_light", effects, baseline=-0.075, std=std)
    write_sensor(tmp_path / "s.json", sensor)
    assert read_sensor(tmp_path / "s.json") == sensor
    entries = {e["effect"]: e["parameters"] for e in json.loads((tmp_path / "s.json").read_text())["effects"]}
    assert entries["vertical_banding"]["steps"] == {"value": [0.1, -0.05], "unit": "px", "std": [0.01, 0.02]}
    assert entries["tabulated"]["variables"]["value"] == ["time", "depth"]
    assert entries["disparity_distortion"]["map"]["value"].endswith(".npy")


def test_the_unit_tells_what_drifts(tmp_path):
    def drift(**parameters):
        return read_sensor(written(tmp_path, [{"effect": "temperature_drift", "parameters": parameters}]))

    metres = drift(coefficient={"value": 0.001, "unit": "m/K", "std": 0.1}, reference_temperature={"value": 30})
    assert metres.effects[0] == TemperatureDrift(coefficient=0.001, reference_temperature=30.0) and not metres.warnings
    pixels = drift(amplitude={"value": 0.2, "unit": "px", "std": 0.1}, time_constant={"value": 800, "unit": "s"})
    assert pixels.effects[0] == TemperatureDrift(amplitude_px=0.2, time_constant=800.0)
    assert pixels.std == {("temperature_drift", "amplitude_px"): 0.1}
    write_sensor(tmp_path / "again.json", pixels)
    assert read_sensor(tmp_path / "again.json").effects == pixels.effects
    assert any("m/K is used" in text for text in drift(coefficient=0.001).warnings)
    with pytest.raises(SensorError, match=r'coefficient\.unit" .* one of "m/K", "px/K"'):
        drift(coefficient={"value": 1, "unit": "mm/K"})
    with pytest.raises(SensorError, match="two units"):
        write_sensor(tmp_path / "s.json", Sensor(effects=(TemperatureDrift(coefficient=0.001, coefficient_px=0.01),)))


def test_a_projector_to_the_left_stays_to_the_left(tmp_path):
    shadow = {"effect": "projector_shadow", "parameters": {"baseline": {"value": -0.075, "unit": "m"}}}
    sensor = read_sensor(written(tmp_path, [shadow]))
    assert sensor.baseline == -0.075 and sensor.effect("projector_shadow").baseline == -0.075
    write_sensor(tmp_path / "s.json", sensor)
    assert read_sensor(tmp_path / "s.json").baseline == -0.075
    near, far = (sensor.predict(np.full((6, 8), z), Camera(8, 6, 585, 585, 3.5, 2.5)) for z in (1.0, 2.0))
    assert np.all(near == 1.0) and np.all(far == 2.0)  # disparities stay positive


TABLE = {"variables": {"value": ["depth"]}, "grid": {"value": [[1, 2]]}}


def offset(**fields):
    return [{"effect": "depth_offset", "parameters": {"offset": fields}}]


def banding(**parameters):
    return [{"effect": "vertical_banding", "parameters": parameters}]


def tabulated(**parameters):
    return [{"effect": "tabulated", "parameters": parameters}]


BROKEN = [
    ("differ in length", banding(columns=[1, 2], steps=[0.1, 0.1, 0.1])),
    (
        r'"parameters\.steps\.std" of effect vertical_banding .* 3 val',
        banding(steps={"value": [0, 0], "std": [1, 2, 3]}),
    ),
    ("does not fit its grid", tabulated(**TABLE, values=[0, 0, 0])),
    (r'variables\.value" of effect tabulated .*depth, range', tabulated(variables={"value": [1]})),
    ("cannot depend on these", tabulated(variables="colour", grid=[1, 2])),
    ("the grid of a table is wrong", tabulated(**TABLE | {"grid": [[2, 1]]})),
    (r'"effect" of effect temp_drift .*one of \d+ names, such as "temperature_drift"', [{"effect": "temp_drift"}]),
    ('"parameters.factor" of .*is not known.*one of scale', [{"effect": "depth_scale", "parameters": {"factor": 1}}]),
    ('offset.unit" of effect depth_offset .*found \'mm\'; expected "m"', offset(value=0.3, unit="mm")),
    (r"from -0\.5 to 0\.5 .*at true depth 0 \[m\].*3 looks like millimetres", offset(value=3)),
    ('offset.value" of effect depth_offset .*found nothing', offset()),
    ("given twice", [{"effect": "depth_offset"}, {"effect": "depth_offset"}]),
    ("one number or a map", offset(value=[0.1, 0.2])),
    ("array of .* cannot be read.*No such file", offset(value="gone.npy")),
    ("expected a number from .* or the name of a .npy file", offset(value="gone.txt")),
    ("outside its folder", offset(value="../gone.npy")),
    ("a finite number", offset(value=float("nan"))),
    ('offset.std" .*of at least 0', offset(value=0, std=-1)),
    ('parameters" of effect depth_offset .*expected a JSON object', [{"effect": "depth_offset", "parameters": [1]}]),
    ("expected a list of effects", {"effect": "depth_offset"}),
]


@pytest.mark.parametrize(("problem", "effects"), BROKEN, ids=[problem for problem, _ in BROKEN])
def test_a_wrong_entry_is_one_clear_line(problem, effects, tmp_path):
    path = written(tmp_path, effects)
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


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_a_mark_before_the_text_changes_nothing(encoding, tmp_path):
    text = written(tmp_path, [{"effect": "depth_offset", "parameters": {"offset": 0.01}}]).read_text()
    (tmp_path / "sensor.json").write_text(text, encoding=encoding)
    assert read_sensor(tmp_path / "sensor.json").effects == (DepthOffset(0.01),)


def test_bounds_hold_for_single_numbers_lists_and_maps(tmp_path):
    np.save(tmp_path / "far.npy", np.full((3, 4), 2.0))
    for value in (2.0, [[2.0, 0.0]], "far.npy"):
        with pytest.raises(SensorError, match=r"-0\.5 to 0\.5"):
            read_sensor(written(tmp_path, [{"effect": "depth_offset", "parameters": {"offset": value}}]))


def test_python_ends_well_after_a_sensor_was_read(tmp_path):
    # msgspec 0.22 crashed there with patterns in types
    path = written(tmp_path, [{"effect": "depth_offset", "parameters": {"offset": 0.01}}])
    program = f"from fusion.sensor.files.sensor_file import read_sensor; read_sensor({str(path)!r})"
    assert subprocess.run([sys.executable, "-c", program], timeout=60).returncode == 0


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(SensorError, match="not there"):
        read_sensor(tmp_path / "gone.json")
