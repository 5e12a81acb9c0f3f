"""Passes beside a simulation: `--ideal` of it makes what the sensor makes of the scene itself, bit for bit."""

import json

import numpy as np
import pytest

from fusion.commands.main import main
from fusion.recording.images.frame_files import INVALID_COUNT
from fusion.recording.open import open_recording
from fusion.sensor.files.sensor_file import read_sensor
from fusion.simulation.ideal.passes import ideal_of
from fusion.simulation.ideal.sense import sense_all
from fusion.simulation.scenes import built_in
from fusion.simulation.simulate import simulate

SCENE = {"frames": "1", "distance_m": "1.2", "tilt_deg": "30"}
SETTINGS = [word for name, value in SCENE.items() for word in ("--set", f"{name}={value}")]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A wall as a Kinect v1 sees it, with its passes."""
    folder = tmp_path_factory.mktemp("passes") / "rec"
    words = ["simulate", "wall", *SETTINGS, "--sensor", "kinect-v1", "--seed", "3", "--passes", "-o", str(folder)]
    assert main(words) == 0
    return folder


@pytest.mark.parametrize("name", ["kinect-v1", "kinect-v2-indoors"])
def test_they_are_what_the_renderer_tells(made, tmp_path, capsys, name):
    assert main(["simulate", "--ideal", str(made), "--sensor", name, "--seed", "3", "-o", str(tmp_path / "out")]) == 0
    told = capsys.readouterr().err
    assert "passes beside the recording are used: " in told and ("lit" in told) == (name == "kinect-v1")
    sensor = read_sensor(name)
    (frame,) = sense_all(
        ideal_of(simulate(built_in("wall", SCENE), read_sensor("kinect-v1"), 3), 1),
        open_recording(made).camera, sensor, 3,
    )  # fmt: skip
    found = open_recording(tmp_path / "out")
    counts = np.rint(np.nan_to_num(frame.depth) * found.camera.depth_scale)
    assert np.array_equal(found.depth_counts(0), np.where(counts < INVALID_COUNT, counts, 0))


def test_what_is_given_comes_before_what_is_found(made, tmp_path, capsys):
    words = ["simulate", "--ideal", str(made), "--sensor", "kinect-v2-indoors", "--json"]
    assert main([*words, "-o", str(tmp_path / "a")]) == 0
    assert main([*words, "--reflectance", "0.1", "-o", str(tmp_path / "b")]) == 0
    assert "reflectance is not given" not in json.dumps(capsys.readouterr().out)
    light = [float(np.median(open_recording(tmp_path / name)[0].ir)) for name in ("a", "b")]
    assert light[1] < 0.3 * light[0]


def test_finer_depth_is_written_where_it_is_asked_for(tmp_path):
    words = ["simulate", "wall", *SETTINGS, "--passes", "2", "-q", "-o", str(tmp_path / "rec")]
    assert main(words) == 0
    camera = open_recording(tmp_path / "rec").camera
    rows = np.load(tmp_path / "rec" / "truth" / "passes" / "rows" / "000000.npy")
    assert rows.shape == (camera.height, 2 * camera.width)


def test_passes_are_made_of_scenes_only(made, tmp_path, capsys):
    words = ["simulate", "--ideal", str(made), "--sensor", "kinect-v1", "--passes", "-o", str(tmp_path / "x")]
    assert main(words) == 1
    assert "passes are made of a scene" in capsys.readouterr().err
