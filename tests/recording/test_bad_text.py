"""Text files with anything in them give a recording or a RecordingError, nothing else."""

import numpy as np
import pytest
import synthetic

from fusion.errors import RecordingError
from fusion.recording.looking.inspect import inspect
from fusion.recording.open import open_recording
from fusion.recording.writing.write import write_recording

FILES = ["camera.json", "depth.txt", "rgb.txt", "groundtruth.txt", "telemetry.csv", "scene.json"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("bad") / "r"
    telemetry = {"timestamp": np.arange(3.0), "turntable_deg": np.arange(3.0)}
    parts = synthetic.trajectory(2), telemetry, {"ambient_lux": 1}
    write_recording(path, synthetic.CAMERA, synthetic.frames(2, color=True), *parts)
    return path


def spoiled(data, random):
    """The bytes with some replaced, cut or repeated; or only random bytes."""
    kind = random.integers(5)
    if kind == 0:
        return random.bytes(int(random.integers(200)))
    if kind == 1:
        return data[: random.integers(len(data))]
    if kind == 2:
        return data + data
    out = bytearray(data)
    for _ in range(random.integers(1, 6)):
        pool = b'0123456789.-eEnaif,#{}[]"\n \t\0\xff' if kind == 3 else bytes(range(256))
        out[random.integers(len(out))] = pool[random.integers(len(pool))]
    return bytes(out)


@pytest.mark.parametrize("name", FILES)
def test_spoiled_text(folder, name):
    path, random = folder / name, np.random.default_rng(11)
    good = path.read_bytes()
    try:
        for _ in range(150):
            path.write_bytes(spoiled(good, random))
            try:
                recording = open_recording(folder)
                recording[0]
            except RecordingError as error:
                assert "\n" not in str(error)
    finally:
        path.write_bytes(good)


@pytest.mark.parametrize(
    ("name", "line"),
    [("depth.txt", "1.0"), ("depth.txt", "nan a.png"), ("groundtruth.txt", "1 2 3"), ("telemetry.csv", "x,1")],
)
def test_the_line_is_named(folder, name, line):
    path = folder / name
    good = path.read_text()
    try:
        path.write_text(good + line + "\n")
        with pytest.raises(RecordingError, match=f"line {len(good.splitlines()) + 1}"):
            open_recording(folder)
    finally:
        path.write_text(good)


def test_spoiled_images(tmp_path):
    write_recording(tmp_path / "r", synthetic.CAMERA, synthetic.frames(2, color=True))
    random = np.random.default_rng(3)
    for name in ("depth/000001.png", "rgb/000001.png"):
        path = tmp_path / "r" / name
        good = path.read_bytes()
        for _ in range(20):
            path.write_bytes(spoiled(good, random))
            recording = open_recording(tmp_path / "r")
            inspect(recording, ())
            try:
                recording[1]
            except RecordingError as error:
                assert "000001.png" in str(error)
        path.write_bytes(good)
