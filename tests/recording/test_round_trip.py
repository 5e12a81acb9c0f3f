"""What is written is read back; what is read is what stands in the files."""

import tracemalloc
from dataclasses import replace

import cv2
import numpy as np
import pytest
import synthetic

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import pose
from fusion.geometry.trajectory import Trajectory
from fusion.recording.formats import tum
from fusion.recording.images.frame_files import associate
from fusion.recording.looking.inspect import inspect
from fusion.recording.native.camera_file import read_camera, write_camera
from fusion.recording.native.trajectory_file import read_trajectory, write_trajectory
from fusion.recording.open import open_recording
from fusion.recording.writing.convert import convert_recording
from fusion.recording.writing.write import depth_counts, write_recording


def test_recording_round_trip(tmp_path):
    frames = synthetic.frames(4, color=True, ir=True)
    telemetry = {"timestamp": np.arange(4.0), "turntable_deg": np.array([0, 1.5, np.nan, 4.5])}
    scene = {"mesh": "a.ply", "ambient_lux": 300.0}
    write_recording(tmp_path / "r", synthetic.CAMERA, frames, synthetic.trajectory(4), telemetry, scene)
    recording = open_recording(tmp_path / "r")
    assert recording.format == "native" and recording.camera == synthetic.CAMERA and not recording.warnings
    for given, read in zip(frames, recording, strict=True):
        # half a count, and float32
        np.testing.assert_allclose(read.depth, given.depth, atol=0.5e-3 + 1e-6)
        np.testing.assert_array_equal(read.color, given.color)
        np.testing.assert_array_equal(read.ir, given.ir)
        assert read.timestamp == pytest.approx(given.timestamp, abs=1e-6)
    # nine decimals in the file
    np.testing.assert_allclose(recording.poses.poses, synthetic.poses(4), atol=1e-8)
    np.testing.assert_array_equal(recording.telemetry["turntable_deg"], telemetry["turntable_deg"])
    assert recording.scene == scene
    write_recording(tmp_path / "again", recording.camera, recording)
    for first, second in zip(recording, open_recording(tmp_path / "again"), strict=True):
        np.testing.assert_array_equal(first.depth, second.depth)


def test_an_older_recording_leaves_nothing_behind(tmp_path):
    write_recording(tmp_path / "r", synthetic.CAMERA, synthetic.frames(3, color=True), synthetic.trajectory(3))
    (tmp_path / "r" / "notes.md").write_text("mine")
    write_recording(tmp_path / "r", synthetic.CAMERA, synthetic.frames(2))
    recording = open_recording(tmp_path / "r")
    assert len(recording) == 2 and recording.poses is None and recording[0].color is None
    assert (tmp_path / "r" / "notes.md").read_text() == "mine"
    assert [path.name for path in tmp_path.iterdir()] == ["r"]


def test_a_failing_frame_leaves_the_older_recording(tmp_path):
    write_recording(tmp_path / "r", synthetic.CAMERA, synthetic.frames(2))
    wrong = replace(synthetic.frames(1)[0], depth=np.ones((3, 3), np.float32))
    with pytest.raises(RecordingError, match="size"):
        write_recording(tmp_path / "r", synthetic.CAMERA, [*synthetic.frames(1), wrong])
    with pytest.raises(RecordingError, match="no frame"):
        write_recording(tmp_path / "r", synthetic.CAMERA, [])
    assert len(open_recording(tmp_path / "r")) == 2
    assert [path.name for path in tmp_path.iterdir()] == ["r"]


def test_counts():
    depth = np.array([[0.0014, 0.0016, np.nan, np.inf, -1.0, 65.534, 65.535, 1e30]])
    np.testing.assert_array_equal(depth_counts(depth, 1000), [[1, 2, 0, 0, 0, 65534, 0, 0]])


def test_invalid_codes_are_nan(tmp_path):
    write_recording(tmp_path / "r", synthetic.CAMERA, synthetic.frames(1))
    counts = np.full(synthetic.CAMERA.shape, 1234, np.uint16)
    counts[0, :2] = 0, 65535
    cv2.imwrite(str(tmp_path / "r/depth/000000.png"), counts)
    depth = open_recording(tmp_path / "r")[0].depth
    assert depth.dtype == np.float32 and np.isnan(depth[0, :2]).all()
    assert depth[0, 2] == np.float32(1.234)


def test_camera_round_trip(tmp_path):
    color = Camera(1920, 1080, 1050.5, 1051.25, 960, 540, (0.1, -0.2, 0.001, 0.002, 0.3, 0.01, 0.02, 0.03))
    T = pose(np.eye(3), [0.05, 0, 0])
    camera = replace(synthetic.CAMERA, serial="17", std={"fx": 0.5}, color=color, T_color_depth=T)
    write_camera(tmp_path / "camera.json", camera)
    read = read_camera(tmp_path / "camera.json")
    assert read == camera
    np.testing.assert_array_equal(read.T_color_depth, T)


@pytest.mark.parametrize("change", ['"fx": NaN', '"fx": -3', '"width": 1.5', '"distortion": [1, 2]', '"cx": "left"'])
def test_bad_camera(tmp_path, change):
    path = tmp_path / "camera.json"
    path.write_text('{"width": 4, "height": 3, "fx": 5, "fy": 5, "cx": 2, "cy": 1, ' + change + "}")
    with pytest.raises(RecordingError, match=change.split('"')[1]):
        read_camera(path)


def test_unknown_keys_of_a_camera_are_ignored_and_absent_ones_named(tmp_path):
    path = tmp_path / "camera.json"
    path.write_text('{"width": 4, "height": 3, "fx": 5, "fy": 5, "cx": 2, "cy": 1, "mood": {"good": []}}')
    assert read_camera(path).depth_scale == 1000
    path.write_text('{"width": 4, "height": 3, "fx": 5, "fy": 5, "cx": 2}')
    with pytest.raises(RecordingError, match="cy"):
        read_camera(path)


def test_trajectory_round_trip(tmp_path):
    given = synthetic.trajectory(5)
    given.poses[2] = np.nan
    write_trajectory(tmp_path / "t.txt", given)
    read = read_trajectory(tmp_path / "t.txt")
    assert len(read) == 4
    # nine decimals
    np.testing.assert_allclose(read.at(given.timestamps).poses, given.poses, atol=1e-8)


def test_association_is_one_to_one_and_in_time():
    depth = np.array([0.0, 0.033, 0.066, 0.1, 5.0])
    other = np.array([0.085, 0.0015, 0.035, 4.0])
    assert associate(depth, other).tolist() == [1, 2, -1, 0, -1]
    assert associate(depth, np.zeros(0)).tolist() == [-1] * 5


def test_stamps_are_sorted_with_a_warning(tmp_path):
    write_recording(tmp_path / "r", synthetic.CAMERA, synthetic.frames(3))
    list_file = tmp_path / "r" / "depth.txt"
    head, title, *lines = list_file.read_text().splitlines()
    list_file.write_text("\n".join([head, title, *reversed(lines)]))
    recording = open_recording(tmp_path / "r")
    assert (np.diff(recording.timestamps) > 0).all() and "order of time" in recording.warnings[0]
    np.testing.assert_allclose(recording[0].depth, synthetic.frames(1)[0].depth, atol=0.6e-3)


@pytest.mark.parametrize("other", [{"fx": 140.0}, {}])
def test_color_of_a_camera_beside_is_kept_apart(tmp_path, other):
    """In its own pixels: of another focal length, or from another place; no frame shows it as if it were registered."""
    place = np.zeros(3) if other else [0.05, 0, 0]
    beside = replace(synthetic.CAMERA, color=replace(synthetic.CAMERA, **other), T_color_depth=pose(np.eye(3), place))
    write_recording(tmp_path / "r", beside, synthetic.frames(2, color=True))
    recording = open_recording(tmp_path / "r")
    assert recording[0].color is None and not recording.warnings
    assert not recording.files.color and list(recording.files.color_apart) == ["rgb/000000.png", "rgb/000001.png"]
    found = inspect(recording)
    assert found.summary["color_frames"] == 2 and found.severity != "error"


def test_color_of_a_camera_beside_is_converted_too(tmp_path):
    color = replace(synthetic.CAMERA, fx=140.0)
    beside = replace(synthetic.CAMERA, color=color, T_color_depth=pose(np.eye(3), [0.05, 0, 0]))
    write_recording(tmp_path / "r", beside, synthetic.frames(2, color=True))
    (tmp_path / "r" / "rgb" / "000001.png").unlink()
    lines = (tmp_path / "r" / "rgb.txt").read_text().splitlines()
    (tmp_path / "r" / "rgb.txt").write_text("\n".join(line for line in lines if "000001" not in line))
    convert_recording(open_recording(tmp_path / "r"), tmp_path / "c")
    copied = open_recording(tmp_path / "c")
    assert copied.files.color_apart == ["rgb/000000.png", None]
    assert (tmp_path / "c/rgb/000000.png").read_bytes() == (tmp_path / "r/rgb/000000.png").read_bytes()


@pytest.mark.parametrize("placed", [True, False])
def test_foreign_color_is_left_out_with_a_warning(tmp_path, placed):
    """Nobody says where its camera stands, or its images are not those of that camera."""
    small = replace(synthetic.CAMERA, width=80, height=60)
    write_recording(tmp_path / "r", synthetic.CAMERA, synthetic.frames(1, color=True))
    camera = replace(synthetic.CAMERA, color=small, T_color_depth=pose(np.eye(3), [0.05, 0, 0]) if placed else None)
    recording = tum.read(tmp_path / "r", camera)
    assert recording[0].color is None and "not registered" in recording.warnings[0]
    assert ("160 x 120" if placed else "T_color_depth") in recording.warnings[0]
    assert not recording.files.color and not recording.files.color_apart


def test_opening_ten_thousand_frames(tmp_path):
    write_recording(tmp_path / "r", synthetic.CAMERA, synthetic.frames(1, color=True))
    for name in ("depth", "rgb"):
        lines = (f"{100 + i / 30:.6f} {name}/000000.png\n" for i in range(10_000))
        (tmp_path / "r" / f"{name}.txt").write_text("".join(lines))
    tracemalloc.start()
    recording = open_recording(tmp_path / "r")
    _, peak = tracemalloc.get_traced_memory()
    recording[9_999]
    recording[5_000]
    held, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(recording) == 10_000
    # measured 7 MB; images of 10 000 frames would be 400 MB
    assert peak < 30e6 and held < 30e6


def test_convert_takes_the_mesh_along(tmp_path):
    write_recording(tmp_path / "r", synthetic.CAMERA, synthetic.frames(2), scene={"mesh": "a.ply"})
    (tmp_path / "r" / "a.ply").write_bytes(b"ply")
    recording = open_recording(tmp_path / "r")
    convert_recording(recording, tmp_path / "n")
    assert (tmp_path / "n" / "a.ply").read_bytes() == b"ply"
    with pytest.raises(RecordingError, match="itself"):
        convert_recording(recording, tmp_path / "r")


def test_empty_trajectory_writes_no_file(tmp_path):
    nothing = Trajectory(np.zeros(1), np.full((1, 4, 4), np.nan))
    write_recording(tmp_path / "r", synthetic.CAMERA, synthetic.frames(1), nothing)
    assert open_recording(tmp_path / "r").poses is None
