"""`fusion calibrate noise` on recordings in folders: what was put in is written, broken input is one line."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fusion.calibration.noise.still import still_parts
from fusion.commands.main import main
from fusion.geometry.camera import Camera
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording
from fusion.sensor.files.sensor_file import read_sensor, write_sensor
from fusion.sensor.sensor import Sensor

CAMERA = Camera(128, 80, 150.0, 150.0, 63.5, 39.5, depth_scale=5000, principle="itof", sensor="T", serial="7")
FRAMES = 24
JITTER = 0.7  # [px]


def sigma_at(z: float) -> float:
    """Noise put in [m]."""
    return 0.001 + 0.001 * z**2


def target(z: float, tilt_deg: float, rng: np.random.Generator) -> np.ndarray:
    """One frame (h, w) [m]: a target 0.4 m wide turned about the vertical, a wall 1 m behind it."""
    t = np.deg2rad(tilt_deg)
    n = np.array([np.sin(t), 0.0, -np.cos(t)])
    plane = n[2] * z / (np.dstack([CAMERA.rays(), np.ones(CAMERA.shape)]) @ n)
    v, u = np.mgrid[0 : CAMERA.height, 0 : CAMERA.width]
    half = 0.2 * np.cos(t) / (z + np.array([-0.2, 0.2]) * np.sin(t))
    ends = [CAMERA.cx + side * CAMERA.fx * h + 0.06 * (v - CAMERA.cy) for side, h in zip((-1, 1), half, strict=True)]
    moved = JITTER * rng.standard_normal((2, CAMERA.height, 1))
    on = (u > ends[0] + moved[0]) & (u < ends[1] + moved[1]) & (np.abs(v - CAMERA.cy) < 32)
    return np.where(on, plane + sigma_at(z) * rng.standard_normal(u.shape), z + 1.0)


def write(path: Path, poses: list[tuple[float, float]], seed: int = 0) -> str:
    """A recording of a target at these distances [m] and tilts [deg], one after the other."""
    rng = np.random.default_rng(seed)
    images = [target(*pose, rng) for pose in poses for _ in range(FRAMES)]
    write_recording(path, CAMERA, [Frame(i, i / 30, image.astype(np.float32)) for i, image in enumerate(images)])
    return str(path)


@pytest.fixture(scope="module")
def recordings(tmp_path_factory) -> list[str]:
    folder = tmp_path_factory.mktemp("targets")
    return [write(folder / f"t{i}", [(z, 0.0), (z, 35.0)], i) for i, z in enumerate((0.7, 1.0, 1.3, 1.6))]


def test_what_was_put_in_is_written(recordings, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["calibrate", "noise", *recordings, "-o", str(out), "--json"]) == 0
    numbers = json.loads(capsys.readouterr().out)
    assert len(numbers["poses"]) == 8 and "angle" in numbers["not_seen"]
    sensor = read_sensor(out / "sensor.json")
    assert sensor.serial == "7"
    noise = sensor.effect("axial_noise")
    for z in (0.7, 1.1, 1.6):
        # 240 pixels of 24 frames: 1 % each, and the target's noise changes over its depth
        assert float(noise.c0 + noise.c1 * z + noise.c2 * z * z) == pytest.approx(sigma_at(z), rel=0.03)
    # 1 % at each of eight distances leave the square's share known to some hundredths, and it is what was put in
    assert noise.c2 == pytest.approx(0.001, abs=4 * sensor.std["axial_noise", "c2"])
    assert 1e-5 < sensor.std["axial_noise", "c2"] < 2e-4
    edge = numbers["lateral"]["parameters"]
    assert edge["sigma_px"]["value"] == pytest.approx(JITTER, rel=0.05)
    low, high = edge["sigma_px"]["interval_90"]
    assert low < edge["sigma_px"]["value"] < high
    assert (out / "report.html").stat().st_size > 40_000


def test_poses_in_one_recording_are_told_apart(recordings):
    assert still_parts(open_recording(recordings[0])) == [range(FRAMES), range(FRAMES, 2 * FRAMES)]


def test_broken_input_is_one_line(recordings, tmp_path, capsys):
    write_sensor(tmp_path / "other.json", Sensor("x", "itof", serial="8"))
    cases = {
        "another camera": [recordings[0], "--sensor", str(tmp_path / "other.json")],
        "no recording": [str(tmp_path / "nothing")],
    }
    blank = np.full(CAMERA.shape, np.nan, np.float32)
    write_recording(tmp_path / "blank", CAMERA, [Frame(i, i / 30, blank) for i in range(12)])
    cases["no target found"] = [str(tmp_path / "blank")]
    plain = target(1.0, 0.0, np.random.default_rng(0)).astype(np.float32)
    write_recording(tmp_path / "frozen", CAMERA, [Frame(i, i / 30, plain) for i in range(12)])
    cases["no pose shows noise"] = [str(tmp_path / "frozen")]
    write_recording(tmp_path / "single", CAMERA, [Frame(0, 0.0, plain)])
    cases["too few frames"] = [str(tmp_path / "single")]
    other = replace(CAMERA, serial="9")
    write_recording(tmp_path / "unit", other, [Frame(0, 0.0, plain)])
    cases["different cameras"] = [recordings[0], str(tmp_path / "unit")]
    for text, arguments in cases.items():
        assert main(["calibrate", "noise", *arguments, "-o", str(tmp_path / "out")]) == 1
        error = capsys.readouterr().err
        assert text in error and error.count("\n") == 1
        assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_pose_without_target_is_left_out_and_told(recordings, tmp_path, capsys):
    blank = np.full(CAMERA.shape, np.nan, np.float32)
    write_recording(tmp_path / "blank", CAMERA, [Frame(i, i / 30, blank) for i in range(12)])
    names = [*recordings[:2], str(tmp_path / "blank")]
    assert main(["calibrate", "noise", *names, "-o", str(tmp_path / "out")]) == 0
    told = capsys.readouterr().out
    assert "left out: no target found" in told and "blank" in told


def test_a_frame_that_cannot_be_read_is_named_once(tmp_path, capsys):
    places = [write(tmp_path / f"t{i}", [(z, 0.0)], i) for i, z in enumerate((0.7, 1.0))]
    (tmp_path / "t0/depth/000002.png").write_bytes(b"no picture")
    assert main(["calibrate", "noise", *places, "-o", str(tmp_path / "out"), "--no-report"]) == 0
    printed = capsys.readouterr().out
    assert printed.count("000002.png") == 1 and "note      t0: 1 frame could not be read" in printed
