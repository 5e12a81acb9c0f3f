"""The published JSON schemas are those of the readers, and fit what the program writes and what others may write."""

import json
import random
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import fusion
from fusion.errors import FusionError
from fusion.sensor.effects import EFFECTS
from fusion.sensor.parameter import parameters
from fusion.sensor.presets import PRESETS
from fusion.sensor.sensor import Sensor
from fusion.simulation.scenes import built_in

PROJECT = Path(__file__).resolve().parent.parent
KINDS = ("camera", "sensor", "scene", "board", "verdict")
SMALL = fusion.Camera(40, 30, 35.0, 35.0, 19.5, 14.5)


@pytest.fixture(scope="module")
def checks():
    """By kind, what tells the faults of the content of a file."""
    found = {}
    for kind in KINDS:
        schema = json.loads((PROJECT / "docs" / "schemas" / f"{kind}.schema.json").read_text(encoding="utf-8"))
        jsonschema.Draft202012Validator.check_schema(schema)
        found[kind] = jsonschema.Draft202012Validator(schema)
    return found


def faults(check, found):
    """What a schema says against the content of a file."""
    return [error.message for error in check.iter_errors(found)]


def content(path):
    return json.loads(path.read_text(encoding="utf-8"))


def test_committed_schemas_are_up_to_date():
    tool = [sys.executable, "-m", "tools.documentation.schemas", "--check"]
    done = subprocess.run(tool, cwd=PROJECT, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, f"{done.stdout}{done.stderr}"


def test_cameras_that_are_written_fit(checks, tmp_path):
    full = replace(SMALL, serial="1", std={"fx": 0.1}, color=SMALL, T_color_depth=np.eye(4), distortion=(0.1,) * 8)
    for camera in (SMALL, full, fusion.find_camera("kinect-v2")):
        fusion.write_camera(tmp_path / "camera.json", camera)
        assert faults(checks["camera"], content(tmp_path / "camera.json")) == []


@pytest.mark.parametrize("name", PRESETS)
def test_presets_that_are_written_fit(checks, tmp_path, name):
    fusion.write_sensor(tmp_path / "sensor.json", fusion.read_sensor(name))
    assert faults(checks["sensor"], content(tmp_path / "sensor.json")) == []


def test_every_effect_that_is_written_fits(checks, tmp_path):
    for kind in EFFECTS:
        first = {about.label: about for about in reversed(parameters(kind).values())}
        effect = kind(**{about.name: about.typical for about in first.values()})
        fusion.write_sensor(tmp_path / "sensor.json", Sensor("s", effects=(effect,)))
        assert faults(checks["sensor"], content(tmp_path / "sensor.json")) == []


@pytest.mark.parametrize("name", ["wall", "charuco"])
def test_simulated_recordings_fit(checks, tmp_path, name):
    scene = replace(built_in(name, {"frames": "1"}), camera=SMALL)
    fusion.write_simulation(tmp_path / "rec", fusion.simulate(scene, fusion.read_sensor("kinect-v1")))
    for kind in ("camera", "scene", *(["board"] if name == "charuco" else [])):
        assert faults(checks[kind], content(tmp_path / "rec" / f"{kind}.json")) == []
    assert faults(checks["sensor"], content(tmp_path / "rec" / "truth" / "sensor.json")) == []


def test_the_example_of_the_documentation_fits(checks):
    text = (PROJECT / "docs" / "scenes.md").read_text(encoding="utf-8")
    assert faults(checks["scene"], json.loads(text.split("```json")[1].split("```")[0])) == []


CAMERA = {"width": 40.0, "height": 30, "fx": 35, "fy": 35, "cx": 19.5, "cy": 14.5}
WRONG = [
    ("camera", CAMERA | {"fx": 0}),
    ("camera", CAMERA | {"width": 40.5}),
    ("camera", CAMERA | {"distortion": [0, 0]}),
    ("camera", CAMERA | {"color": CAMERA | {"T_color_depth": [[1, 0], [0, 1]]}}),
    ("camera", {}),
    ("board", {"columns": 9, "rows": 6, "square_m": 40}),
    ("board", {"columns": 9, "rows": 6}),
    ("scene", {"reflectance": 2}),
    ("scene", {"poses": {"source": "guessed"}}),
    ("scene", {"parts": [{"pose": "there"}]}),
    ("scene", {"trajectory": {"turntable": {"frames": 0}}}),
    ("sensor", {"effects": []}),
    ("sensor", {"format": "fusion-sensor/1", "effects": [{"effect": "wiggle"}]}),
    ("sensor", {"format": "fusion-sensor/1", "effects": [{"effect": "depth_offset", "parameters": {"x": 1}}]}),
    ("sensor", {"format": "fusion-sensor/1", "effects": [{"effect": "depth_offset", "parameters": {"offset": 9}}]}),
]


@pytest.mark.parametrize(("kind", "wrong"), WRONG, ids=[str(wrong)[:50] for _, wrong in WRONG])
def test_what_cannot_be_fits_no_schema(checks, kind, wrong):
    assert faults(checks[kind], wrong)


HARM = [None, True, "", "text", 0, -1, 1e9, 0.5, 3, [], {}, [1], [[1, 2]], {"value": 1}, "nominal", "m", "unknown"]
SCENE = {
    "mesh": "a.ply",
    "reflectance": 0.5,
    "poses": {"source": "nominal", "sigma_m": 0.1},
    "ambient_lux": 3,
    "trajectory": {"turntable": {"axis_point": [0, 0, 0], "frames": 3, "errors": {"slip_deg": 1}}, "continuous": True},
}
OFFSET = {"effect": "depth_offset", "parameters": {"offset": {"value": 0.1, "unit": "m", "std": 0.01}}, "source": "s"}
SENSOR = {"format": "fusion-sensor/1", "name": "n", "principle": "itof", "baseline_m": 0.1, "effects": [OFFSET]}


def harmed(value, rng):
    """The value with something in it replaced."""
    if isinstance(value, dict) and value and rng.random() < 0.85:
        key = rng.choice(list(value))
        return value | {key: harmed(value[key], rng)}
    if isinstance(value, list) and value and rng.random() < 0.7:
        place = rng.randrange(len(value))
        return [*value[:place], harmed(value[place], rng), *value[place + 1 :]]
    return rng.choice(HARM)


def test_what_is_read_fits_the_schema(checks, tmp_path):
    # the other way round does not hold: a schema cannot look at everything
    from fusion.recording.native.scene_file import read_scene_fields

    readers = {"camera": fusion.find_camera, "scene": read_scene_fields, "sensor": fusion.read_sensor}
    full = CAMERA | {"std": {"fx": 1}, "color": CAMERA, "distortion": [0.1] * 5, "principle": "itof", "serial": "a"}
    rng = random.Random(5)
    read = 0
    for kind, good in (("camera", full), ("scene", SCENE), ("sensor", SENSOR)):
        path = tmp_path / f"{kind}.json"
        for _ in range(120):
            bad = harmed(good, rng)
            path.write_text(json.dumps(bad))
            try:
                readers[kind](path)
            except FusionError:
                continue
            read += 1
            assert faults(checks[kind], bad) == []
    assert read > 30
