"""`fusion simulate` and `fusion sensor`: what they print, what they write, and what they say about wrong input."""

import json

import pytest

from fusion.commands.main import main
from fusion.geometry.camera import Camera
from fusion.recording.native.camera_file import write_camera
from fusion.recording.open import open_recording
from fusion.sensor.presets import PRESETS, preset
from fusion.simulation.scenes import SCENES


@pytest.fixture
def small(tmp_path):
    write_camera(tmp_path / "small.json", Camera(64, 48, 57.0, 57.0, 31.5, 23.5, depth_scale=5000.0))
    return ["--camera", str(tmp_path / "small.json")]


def test_a_scene_by_name_with_settings_becomes_a_recording(tmp_path, small, capsys):
    wanted = ["simulate", "wall", "-o", str(tmp_path / "rec"), "--sensor", "kinect-v1", "--seed", "3", *small]
    assert main([*wanted, "--set", "distance_m=0.9,1.8", "--set", "frames=2", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["frames"] == 4 and told["seed"] == 3 and told["sensor"] == "kinect-v1"
    recording = open_recording(tmp_path / "rec")
    assert recording.camera.width == 64 and recording.camera.principle == "structured_light"
    assert list(recording.telemetry["distance_m"]) == [0.9, 0.9, 1.8, 1.8]


def test_without_a_sensor_the_depth_is_the_truth(tmp_path, small, capsys):
    assert main(["simulate", "wall", "-o", str(tmp_path / "rec"), "--set", "frames=1", *small]) == 0
    depth = open_recording(tmp_path / "rec")[0].depth
    assert abs(depth - 1.0).max() <= 0.5 / 5000 + 1e-6  # half a count
    assert "as ideal sees it" in capsys.readouterr().out


@pytest.mark.parametrize(
    "arguments",
    [
        ["nowhere"],
        ["wall", "--set", "frames"],
        ["wall", "--set", "colour=red"],
        ["wall", "--set", "frames=0"],
        ["wall", "--seed", "-1"],
        ["wall", "--sensor", "nothing"],
        ["wall", "--camera", "nothing"],
        ["scene.json", "--set", "frames=3"],
        ["turntable", "--set", "mesh=nothing.ply"],
    ],
)
def test_wrong_input_is_one_line_and_writes_nothing(tmp_path, capsys, arguments):
    assert main(["simulate", *arguments, "-o", str(tmp_path / "rec")]) == 1
    told = capsys.readouterr().err
    assert told.count("\n") == 1 and told.startswith("fusion simulate: ")
    assert not (tmp_path / "rec").exists()


def test_a_scene_or_an_output_must_be_given(capsys):
    assert main(["simulate"]) == 2
    assert main(["simulate", "wall"]) == 2
    assert "-o REC" in capsys.readouterr().err


def test_the_list_names_every_scene_and_setting(capsys):
    assert main(["simulate", "--list"]) == 0
    told = capsys.readouterr().out
    assert [line.split()[0] for line in told.split("\n\n")[0].splitlines()] == list(SCENES)
    assert max(map(len, told.splitlines())) <= 120
    assert main(["simulate", "wall", "--list"]) == 0
    assert "--set distance_m=1\n" in capsys.readouterr().out
    assert main(["simulate", "nowhere", "--list"]) == 1
    assert main(["simulate", "--list", "--json"]) == 0
    assert json.loads(capsys.readouterr().out).keys() == SCENES.keys()


@pytest.mark.parametrize("columns", [80, 120])
@pytest.mark.parametrize("name", PRESETS)
def test_a_sensor_is_a_table_with_units_and_sources(name, columns, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(columns))
    assert main(["sensor", "show", name]) == 0
    told = capsys.readouterr().out
    assert max(map(len, told.splitlines())) <= columns
    sensor = preset(name)
    for effect in sensor.effects:
        assert f"\n{effect.name}\n" in told
    assert told.count("  source: ") == len(sensor.effects) and "not stated" not in told
    assert main(["sensor", "show", name, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert [entry["effect"] for entry in content["effects"]] == [effect.name for effect in sensor.effects]


def test_a_sensor_file_is_shown_with_what_is_known_of_it(tmp_path, capsys):
    entries = [
        {"effect": "depth_offset", "parameters": {"offset": {"value": 0.004, "unit": "m", "std": 0.001}}},
        {
            "effect": "cyclic_error",
            "parameters": {
                "amplitude": {"value": [0.004, 0.0021, 0.0011], "unit": "m", "std": [0.001, 0.001, 0.0005]},
                "period": {"value": [0.9375, 0.46875, 0.3125], "unit": "m", "std": 0},
                "phase": {"value": [0.1, 0.2, 0.3], "unit": "rad"},
            },
        },
        {"effect": "voxelization", "parameters": {"voxel": 0.002}},
    ]
    content = {"format": "fusion-sensor/1", "name": "mine", "principle": "itof", "effects": entries}
    (tmp_path / "mine.json").write_text(json.dumps(content))
    assert main(["sensor", "show", str(tmp_path / "mine.json")]) == 0
    told = capsys.readouterr().out
    for part in [
        "mine: itof",
        "0.004     0.001  m",
        "0.9375, 0.46875, 0.3125",
        "left out: voxelization",
        "source: not",
    ]:
        assert part in told, part


def test_the_list_of_sensors(capsys):
    assert main(["sensor", "list"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == list(PRESETS)
    assert main(["sensor", "list", "--json"]) == 0
    assert json.loads(capsys.readouterr().out).keys() == set(PRESETS)
    assert main(["sensor", "show"]) == 1
