"""`fusion evaluate` writes its two files, or nothing and one line."""

import json

import cv2
import numpy as np

from fusion.commands.main import main
from fusion.geometry.camera import Camera
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording

CAMERA = Camera(64, 48, 60.0, 60.0, 31.5, 23.5, depth_scale=5000, principle="itof")


def made(folder, count: int = 8, distance: float = 1.0) -> str:
    rng = np.random.default_rng(0)
    images = [(distance + 0.002 * rng.standard_normal(CAMERA.shape)).astype(np.float32) for _ in range(count)]
    telemetry = {"timestamp": [0.0, 9.0], "distance_m": [distance, distance]}
    frames = [Frame(i, i / 30, image, ir=np.full(CAMERA.shape, 500 + i, np.uint16)) for i, image in enumerate(images)]
    write_recording(folder, CAMERA, frames, telemetry=telemetry)
    return str(folder)


def test_it_writes_numbers_and_report(tmp_path, capsys):
    places = [made(tmp_path / f"wall_{z}", distance=z) for z in (1.0, 1.5)]
    out = tmp_path / "out"
    assert main(["evaluate", *places, "-o", str(out), "--sensor", "kinect-v2-indoors", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    written = json.loads((out / "evaluation.json").read_text())
    assert written["summary"] == told["summary"] and len(written["stretches"]) == 2
    page = (out / "report.html").read_text(encoding="utf-8")
    for part in ("Sensor evaluation", "Noise of the depth", "Residuals from the surface", "IR: mean and noise",
                 "The depth is off by", "Quantisation", "values are valid"):  # fmt: skip
        assert part in page
    assert "<svg" in page and "nan mm" not in page


def test_a_recording_of_zeros_is_one_line_and_leaves_nothing(tmp_path, capsys):
    folder = tmp_path / "empty"
    made(folder)
    (folder / "telemetry.csv").unlink()
    for path in (folder / "depth").iterdir():
        cv2.imwrite(str(path), np.zeros(CAMERA.shape, np.uint16))
    assert main(["evaluate", str(folder), "-o", str(tmp_path / "out")]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and "no frame has a depth" in error
    assert not (tmp_path / "out").exists()


def test_frames_of_a_camera_that_is_carried_are_counted(tmp_path, capsys):
    rng = np.random.default_rng(0)
    far = [1.0] * 8 + [1.3, 1.6, 1.9] + [2.4] * 8
    images = [(z + 0.002 * rng.standard_normal(CAMERA.shape)).astype(np.float32) for z in far]
    write_recording(tmp_path / "rec", CAMERA, [Frame(i, i / 30, image) for i, image in enumerate(images)])
    said = "3 of 19 frames belong to no view that stands still: left out"
    for words in (["evaluate"], ["calibrate", "depth"]):
        out = str(tmp_path / words[-1])
        assert main([*words, str(tmp_path / "rec"), "-o", out, "--no-report"]) == 0
        assert capsys.readouterr().out.count(said) == 1
