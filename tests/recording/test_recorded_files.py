"""Recorded files of other programs, written as their formats are described."""

import struct
import zlib

import cv2
import numpy as np
import pytest
import rendered

from fusion import convert_recording, open_recording
from fusion.errors import RecordingError

CLOSE = 0.15e-3  # 0.2 px are 0.9 mm or more
LENS = (600.0, 605.0, 331.0, 229.0)  # fx, fy, cx, cy from the first pixel's centre, of 640 x 480
T_COLOR_DEPTH = np.array([[1, 0, 0, 0.025], [0, 1, 0, -0.002], [0, 0, 1, 0.001], [0, 0, 0, 1.0]])
AXES = np.diag([1.0, -1, -1, 1])


def seen(i, size=(640, 480)):
    """Counts of millimetres, and faces."""
    scale = size[0] / 640
    fx, fy = LENS[0] * scale, LENS[1] * scale
    z, face = rendered.depth(rendered.cameras()[i], *size, fx, fy, LENS[2] * scale + 0.5, LENS[3] * scale + 0.5)
    return np.rint(1000 * z).astype("<u2"), face


def matrix(fx, fy, cx, cy):
    return np.array([[fx, 0, cx, 0], [0, fy, cy, 0], [0, 0, 1, 0], [0, 0, 0, 1]], "<f4")


def sens(path, packed=1, apart=False, frames=3, lost=None):
    data = struct.pack("<IQ", 4, 9) + b"Structure"
    places = [np.eye(4), T_COLOR_DEPTH if apart else np.eye(4)]
    color = (1100.0, 1105.0, 650.0, 470.0) if apart else LENS
    for K, E in zip((color, LENS), places, strict=True):
        data += matrix(*K).tobytes() + E.astype("<f4").tobytes()
    size = (1296, 968) if apart else (640, 480)
    data += struct.pack("<ii4IfQ", 2, packed, *size, 640, 480, 1000.0, frames)
    for i in range(3):
        counts = seen(i)[0].tobytes()
        depth = zlib.compress(counts) if packed else counts
        picture = cv2.imencode(".jpg", np.full((size[1], size[0], 3), (200, 90, 30 * i), np.uint8))[1].tobytes()
        T = np.full((4, 4), -np.inf) if i == lost else rendered.cameras()[i] @ AXES
        data += T.astype("<f4").tobytes() + struct.pack("<4Q", 0, 33_333 * i + 7, len(picture), len(depth))
        data += picture + depth
    path.write_bytes(data)
    return path


def klg(path, packed=True, pictures=True, frames=3):
    data = struct.pack("<i", frames)
    for i in range(3):
        counts = seen(i)[0].tobytes()
        depth = zlib.compress(counts) if packed else counts
        picture = cv2.imencode(".jpg", np.full((480, 640, 3), 90, np.uint8))[1].tobytes() if pictures else b""
        data += struct.pack("<qii", 1_000_000 + 33_333 * i, len(depth), len(picture)) + depth + picture
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("packed", [0, 1])
@pytest.mark.parametrize("apart", [False, True])
def test_sens(tmp_path, packed, apart):
    recording = open_recording(sens(tmp_path / "x", packed, apart))
    assert recording.format == "sens" and recording.color_is_apart == apart
    worst = np.abs(rendered.errors(recording, [seen(i)[1] for i in range(3)]))
    assert len(worst) >= 12 and worst.max() < CLOSE
    np.testing.assert_allclose(np.diff(recording.timestamps), 0.033333)
    color = recording.color_apart(2) if apart else recording[2].color
    np.testing.assert_allclose(color[9, 9], [60, 90, 200], atol=4)
    if apart:
        np.testing.assert_allclose(recording.camera.T_color_depth, T_COLOR_DEPTH, atol=1e-6)
    convert_recording(recording, tmp_path / "native")
    np.testing.assert_array_equal(open_recording(tmp_path / "native")[1].depth, recording[1].depth)


def test_a_pose_that_was_lost(tmp_path):
    recording = open_recording(sens(tmp_path / "x", lost=1))
    assert recording.poses.valid.tolist() == [True, False, True]


@pytest.mark.parametrize("packed", [True, False])
@pytest.mark.parametrize("pictures", [True, False])
def test_klg(tmp_path, packed, pictures):
    path = klg(tmp_path / "x", packed, pictures)
    with pytest.raises(RecordingError, match=r"--camera fx,fy,cx,cy"):
        open_recording(path)
    recording = open_recording(path, "600,605,331,229")
    assert recording.format == "klg" and recording.camera.shape == (480, 640)
    assert (recording[0].color is not None) == pictures
    for i, frame in enumerate(recording):
        np.testing.assert_array_equal(np.nan_to_num(frame.depth), seen(i)[0].astype(np.float32) / np.float32(1000))
    np.testing.assert_allclose(recording.timestamps[0], 1.0)


@pytest.mark.parametrize("write", [sens, klg])
def test_cut_files_keep_their_whole_frames(tmp_path, write):
    whole = write(tmp_path / "x").read_bytes()
    (tmp_path / "cut").write_bytes(whole[:-100])
    recording = open_recording(tmp_path / "cut", "600,605,331,229")
    assert len(recording) == 2 and any("2 of 3" in told for told in recording.warnings)
    for size in (0, 3, 20, 100, 330):
        (tmp_path / "cut").write_bytes(whole[:size])
        with pytest.raises(RecordingError):
            open_recording(tmp_path / "cut", "600,605,331,229")


@pytest.mark.parametrize("write", [sens, klg])
def test_a_count_of_frames_that_lies(tmp_path, write):
    recording = open_recording(write(tmp_path / "x", frames=2**31 - 1 if write is sens else 30), "600,605,331,229")
    assert len(recording) == 3


@pytest.mark.parametrize("write", [sens, klg])
def test_changed_bytes_are_one_line(tmp_path, write):
    whole = write(tmp_path / "x").read_bytes()
    random = np.random.default_rng(4)
    for k in range(40):
        data = bytearray(whole)
        for at in random.integers(0, len(data) if k % 2 else 500, 4):
            data[at] = random.integers(256)
        (tmp_path / "bad").write_bytes(bytes(data))
        try:
            list(open_recording(tmp_path / "bad", "600,605,331,229"))
        except RecordingError as problem:
            assert "\n" not in str(problem)
