"""A model for other simulators: the law that it is fitted to is the one that each of them publishes.

The published laws are written down here once more, from their sources, as draws; the module states their moments.
"""

import json
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from fusion.commands.main import main
from fusion.recording.open import open_recording
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.files.sensor_file import read_sensor
from fusion.sensor.sensor import Sensor
from fusion.sensor.working_range import WorkingRange
from fusion.simulation.exporting.compare import compare_recording, compare_sensors
from fusion.simulation.exporting.export import export_sensor
from fusion.simulation.exporting.loss import usual_camera
from fusion.simulation.exporting.targets import TARGETS

DRAWS = 40_000


def isaac(given, z, rng):
    """ovrtx, Camera single-view stereo depth model: distance to disparity, Gaussian noise in pixels, and back."""
    disparity = given["baselineMM"] / 1000 * given["focalLengthPixel"] / z
    return disparity * z / (disparity + rng.normal(given["noiseMean"], given["noiseSigma"], DRAWS))


def gazebo(given, z, rng):
    """gz-sensors, ImageGaussianNoiseModel: a normal number is added to every value of the depth image."""
    return z + rng.normal(given["mean"], given["stddev"], DRAWS)


def habitat(given, z, rng):
    """habitat-sim, RedwoodDepthNoiseModel without the table of distortions."""
    noise = rng.standard_normal(DRAWS) * 0.027778 * given["noise_multiplier"]
    return 35.130 * 8 / np.round((35.130 / z + noise) * 8)


def blenderproc(given, z, rng):
    """BlenderProc, add_kinect_azure_noise on a wall: 0.5 mm, and 1 mm more for each metre beyond 0.5 m."""
    spread = 5 / 10000 + max((z - 0.5) / 1000, 0)
    return z + given["add_kinect_azure_noise"] * spread * rng.standard_normal(DRAWS)


def mujoco(given, z, rng):
    """mujoco.Renderer: z = D / (ndc + C) of a buffer of 24 bits, around this depth."""
    near, far = given["znear"], given["zfar"]
    C, D = -(far + near) / (far - near), -2 * far * near / (far - near)
    true = z * (1 + rng.uniform(-1e-3, 1e-3, DRAWS))
    window = ((D / true - C) + 1) / 2  # what the buffer is given
    return z + D / (2 * (np.round(window * 2**24) / 2**24) - 1 + C) - true


PUBLISHED = {"isaac": isaac, "gazebo": gazebo, "habitat": habitat, "blenderproc": blenderproc, "mujoco": mujoco}


@pytest.mark.parametrize("model", ["kinect-v1", "kinect-v2-indoors", "realsense-d435"])
@pytest.mark.parametrize("name", TARGETS)
def test_the_moments_are_those_of_the_published_law(name, model):
    sensor = read_sensor(model)
    made = export_sensor(sensor, name, usual_camera(sensor))
    rng = np.random.default_rng(1)
    for row, z in enumerate(made.loss.depths):
        drawn = PUBLISHED[name](made.parameters, z, rng) - z
        mean, sigma = made.loss.exported[row]
        # four standard errors; and what a law in disparity bends in third order, below 0.1 % of the spread
        assert abs(drawn.mean() - mean) < 4 * drawn.std() / np.sqrt(DRAWS) + 1e-3 * sigma + 1e-9
        # a rounded value is not normal, its spread is known no better than 4 / sqrt(DRAWS)
        assert abs(drawn.std() - sigma) < (4 / np.sqrt(DRAWS) + 2e-3) * sigma + 1e-9


@pytest.mark.parametrize("name", ["isaac", "habitat", "gazebo"])
def test_what_a_law_can_hold_comes_through(name):
    """A sensor that is the other simulator's own law is exported without loss."""
    camera = usual_camera(read_sensor("kinect-v1"))
    fb = camera.fx * 0.075
    own = {
        "isaac": AxialNoise(sigma_px=0.1),
        "habitat": AxialNoise(c2=0.2 / 35.130),  # so rough that rounding to 1/8 px is nothing beside it
        "gazebo": AxialNoise(c0=0.004),
    }[name]
    sensor = Sensor("own", "structured_light", (own,), baseline=0.075)
    made = export_sensor(sensor, name, camera)
    # a law of the disparity bends: its mean error is the share of the noise in the disparity times its spread
    sigma = made.loss.own[:, 1]
    share = 0.0 if name == "gazebo" else sigma / made.loss.depths
    assert (made.loss.rms <= (0.005 + 1.2 * share) * sigma + 1e-6).all(), made.loss.rms / sigma
    if name == "isaac":
        assert made.parameters["noiseSigma"] == pytest.approx(0.1, rel=5e-3)  # the walls lie around each depth
        assert made.parameters["baselineMM"] * made.parameters["focalLengthPixel"] == pytest.approx(1000 * fb)
    if name == "gazebo":
        assert made.parameters["stddev"] == pytest.approx(0.004, rel=1e-3)


def test_an_offset_is_a_mean_where_there_is_one():
    sensor = Sensor("off", "structured_light", (DepthOffset(offset=0.01),))
    made = export_sensor(sensor, "gazebo", usual_camera(sensor))
    assert made.parameters["mean"] == pytest.approx(0.01, rel=1e-3) and made.loss.rms.max() < 1e-5
    assert (export_sensor(sensor, "mujoco", usual_camera(sensor)).loss.rms > 0.0099).all()


@pytest.mark.parametrize("name", TARGETS)
def test_the_loss_is_at_most_that_of_no_export_where_the_law_was_fitted(name):
    """In what it was fitted to: the sum over depths, in disparity where that is where the law is a constant."""
    sensor = read_sensor("realsense-d435")
    loss = export_sensor(sensor, name, usual_camera(sensor)).loss
    weight = loss.depths ** (-2.0 if name in ("isaac", "habitat") else 0.0)
    assert (weight * loss.rms**2).sum() <= (weight * loss.whole**2).sum() * 1.001


@pytest.mark.slow
def test_every_file_can_be_read_by_what_it_is_for(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name in TARGETS:
        assert main(f"sensor export kinect-v1 --to {name} -o {name}.txt --json".split()) == 0
        told = json.loads(capsys.readouterr().out)
        assert len(told["rms"]) == len(told["depths"]) and told["source"] and "vertical_banding" in told["lost"]
    sdf = ElementTree.parse("gazebo.txt").getroot()
    assert float(sdf.find("camera/noise/stddev").text) > 0 and sdf.get("type") == "depth_camera"
    camera = ElementTree.parse("mujoco.txt").getroot().find("worldbody/camera")
    assert camera.get("resolution") == "640 480"
    compile((tmp_path / "blenderproc.txt").read_text(), "blenderproc.txt", "exec")
    assert json.loads((tmp_path / "habitat.txt").read_text())["noise_model"] == "RedwoodDepthNoiseModel"
    assert "depthSensor:noiseSigma" in (tmp_path / "isaac.txt").read_text()


@pytest.mark.slow
def test_a_model_beside_itself_is_nowhere_apart_and_beside_another_it_is(tmp_path, capsys):
    one, other = read_sensor("kinect-v1"), read_sensor("realsense-d435")
    assert compare_sensors(one, one, usual_camera(one)).apart.max() == 0
    assert (compare_sensors(one, other, usual_camera(one)).apart > 0).all()
    assert main(["sensor", "compare", "kinect-v1", "azure-kinect", "--json", "-o", str(tmp_path / "out")]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["parameters"]["depth_quantization.step"] == [0.0, 0.001]
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert page.count("<figure>") == 3 and json.loads((tmp_path / "out" / "comparison.json").read_text()) == told


@pytest.mark.slow
def test_a_recording_of_a_sensor_has_the_spread_of_its_model(tmp_path):
    words = "simulate wall --set frames=25 --set distance_m=1 --sensor kinect-v1 --quiet -o"
    assert main([*words.split(), str(tmp_path / "rec")]) == 0
    found = compare_recording(read_sensor("kinect-v1"), open_recording(tmp_path / "rec"))
    assert (np.abs(found.depths - 1) < 0.01).all() and len(found.depths)
    # a spread of 25 frames has a median 1.4 % low; rounding to 1/8 px, 3 mm there, sorts pixels of like means together
    ratio = found.other.sigma / found.one.sigma
    assert np.abs(ratio - 1).max() < 0.2 and abs(ratio.mean() - 1) < 0.08


@pytest.mark.parametrize(
    "words",
    [
        "export kinect-v1 -o out", "export kinect-v1 --to isaac", "export kinect-v1 --to unity -o out",
        "compare kinect-v1", "compare kinect-v1 nothing", "show kinect-v1 -o out", "compare kinect-v1 .",
    ],
)  # fmt: skip
def test_wrong_usage_is_one_line_and_writes_nothing(tmp_path, monkeypatch, capsys, words):
    monkeypatch.chdir(tmp_path)
    assert main(["sensor", *words.split()]) == 1
    assert capsys.readouterr().err.count("\n") == 1 and not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["isaac", "gazebo", "mujoco"])
def test_where_a_sensor_gives_values_is_what_the_other_simulator_renders(name):
    sensor = read_sensor("kinect-v1")
    limited, free = (
        export_sensor(one, name, usual_camera(sensor)) for one in (sensor, replace(sensor, works=WorkingRange()))
    )
    near, far = {"isaac": ("minDistance", "maxDistance"), "gazebo": ("near", "far"), "mujoco": ("znear", "zfar")}[name]
    assert (limited.parameters[near], limited.parameters[far]) == (0.4, 10.0)
    assert free.parameters[near] == 0.2 and "0.4" in limited.text
