"""Fixtures in the published layout of each foreign format."""

import json

import cv2
import numpy as np
import pytest
import synthetic

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import inverse
from fusion.recording.looking.inspect import inspect
from fusion.recording.open import open_recording
from fusion.recording.writing.convert import convert_recording
from fusion.recording.writing.write import depth_counts, write_recording

FRAMES = synthetic.frames(3)
POSES = synthetic.poses(3)
COLOR = np.full((*synthetic.CAMERA.shape, 3), (200, 100, 50), np.uint8)  # RGB


def image(path, array):
    path.parent.mkdir(parents=True, exist_ok=True)
    array = array[..., ::-1] if array.ndim == 3 else array
    assert cv2.imwrite(str(path), array)


def seven_scenes(folder):
    for i, frame in enumerate(FRAMES):
        counts = depth_counts(frame.depth, 1000)
        counts[counts == 0] = 65535
        image(folder / f"frame-{i:06d}.depth.png", counts)
        image(folder / f"frame-{i:06d}.color.png", COLOR)
        rows = "".join("\t ".join(f"{v: .7e}" for v in row) + "\t \n" for row in POSES[i])
        (folder / f"frame-{i:06d}.pose.txt").write_text(rows)
    return synthetic.CAMERA


def bop(folder):
    cameras = {}
    for i, frame in enumerate(FRAMES):
        image(folder / "depth" / f"{i:06d}.png", depth_counts(frame.depth, 10000))
        image(folder / "rgb" / f"{i:06d}.png", COLOR)
        T = inverse(POSES[i])
        cameras[str(i)] = {
            "cam_K": synthetic.CAMERA.matrix.reshape(-1).tolist(),
            "depth_scale": 0.1,
            "cam_R_w2c": T[:3, :3].reshape(-1).tolist(),
            "cam_t_w2c": (1000 * T[:3, 3]).tolist(),
        }
    (folder / "scene_camera.json").write_text(json.dumps(cameras))


def open3d(folder):
    log = ""
    for i, frame in enumerate(FRAMES):
        image(folder / "depth" / f"{i:06d}.png", depth_counts(frame.depth, 1000))
        image(folder / "color" / f"{i:06d}.png", COLOR)
        log += f"{i} {i} {i + 1}\n" + "".join(" ".join(f"{v:.8f}" for v in row) + "\n" for row in POSES[i])
    K = synthetic.CAMERA.matrix.T.reshape(-1).tolist()
    (folder / "intrinsic.json").write_text(json.dumps({"width": 160, "height": 120, "intrinsic_matrix": K}))
    (folder / "trajectory.log").write_text(log)


def plain_tum(folder):
    write_recording(folder, synthetic.CAMERA, FRAMES, synthetic.trajectory(3))
    (folder / "camera.json").unlink()
    return synthetic.CAMERA


@pytest.mark.parametrize(
    ("write", "name"), [(seven_scenes, "7scenes"), (bop, "bop"), (open3d, "open3d"), (plain_tum, "tum")]
)
def test_format(tmp_path, write, name):
    folder = tmp_path / "r"
    folder.mkdir()
    recording = open_recording(folder, write(folder))
    assert recording.format == name and len(recording) == 3
    np.testing.assert_allclose(recording.camera.matrix, synthetic.CAMERA.matrix)
    for frame, given in zip(recording, FRAMES, strict=True):
        # half a millimetre, the coarsest count of these formats
        np.testing.assert_allclose(frame.depth, given.depth, atol=0.51e-3)
        if name != "tum":
            assert frame.color[3, 4].tolist() == [200, 100, 50]
    # seven decimals in the files
    np.testing.assert_allclose(recording.poses.at(recording.timestamps).poses, POSES, atol=1e-6)
    assert inspect(recording).severity != "error"
    convert_recording(recording, tmp_path / "native")
    native = open_recording(tmp_path / "native")
    np.testing.assert_array_equal(native[2].depth, recording[2].depth)


@pytest.mark.parametrize(
    ("depth", "color", "joined", "told"),
    [
        (["a_depth", "b_depth"], ["a_color", "b_color", "c_color"], [0, 1], "the words"),
        (["0-33", "1-66"], ["1-40", "2-70", "0-10"], [2, 0], "the number"),
        (["a1", "b1"], ["a2", "b2", "c3"], [None, None], "left out"),  # no number stands for one image
        (["left", "right"], ["one", "two", "three"], [None, None], "left out"),
    ],
)
def test_colours_go_with_the_depth_that_their_names_say(tmp_path, depth, color, joined, told):
    open3d(tmp_path)
    for kind, names in (("depth", depth), ("color", color)):
        for old in (tmp_path / kind).iterdir():
            old.unlink()
        for i, name in enumerate(names):
            value = np.full(synthetic.CAMERA.shape, 900, np.uint16) if kind == "depth" else np.full_like(COLOR, 60 * i)
            image(tmp_path / kind / f"{name}.png", value)
    recording = open_recording(tmp_path)
    assert any(told in warning for warning in recording.warnings)
    frames = list(recording)
    assert [None if f.color is None else int(f.color[0, 0, 0]) // 60 for f in frames] == joined


def test_seven_scenes_with_colours_in_jpeg(tmp_path):
    camera = seven_scenes(tmp_path)
    for name in tmp_path.glob("*.color.png"):
        image(name.with_suffix(".jpg"), COLOR)
        name.unlink()
    for frame in open_recording(tmp_path, camera):
        np.testing.assert_allclose(frame.color[3, 4], [200, 100, 50], atol=3)


@pytest.mark.parametrize("order", ["<u2", ">u2"])
@pytest.mark.parametrize("raw", [True, False])
def test_fakenect(tmp_path, order, raw):
    v, u = np.mgrid[0:480, 0:640]
    counts = (500 + u // 2 + v // 4 if raw else 1500 + 3 * u + v).astype(np.uint16)
    counts[:20] = 2047 if raw else 0
    (tmp_path / "d-12.500000-77.pgm").write_bytes(b"P5 640 480 65535\n" + counts.astype(order).tobytes())
    (tmp_path / "r-12.510000-78.ppm").write_bytes(b"P6 640 480 255\n" + bytes((9, 8, 7)) * (640 * 480))
    (tmp_path / "INDEX.txt").write_text("r-12.510000-78.ppm\na-12.5-1.dump\nd-12.500000-77.pgm\n")
    recording = open_recording(tmp_path)
    frame = recording[0]
    assert recording.format == "fakenect" and frame.timestamp == 12.5
    expected = by_tangent(counts) if raw else np.where(counts == 0, np.nan, counts / 1000)
    np.testing.assert_allclose(frame.depth, expected, rtol=0.015 if raw else 1e-6)
    assert np.isnan(frame.depth[:20]).all() and frame.color[0, 0].tolist() == [9, 8, 7]
    notes: list[str] = []
    convert_recording(recording, tmp_path / "native", notes)
    kept = open_recording(tmp_path / "native")[0].depth
    if raw:  # no two raw values become one count; what is rounded is told
        assert np.abs(kept - frame.depth)[20:].max() < 0.11e-3
        assert any("rounded to whole counts of 0.2 mm" in note for note in notes)
    else:
        assert np.array_equal(kept, frame.depth, equal_nan=True) and not any("rounded" in note for note in notes)


def by_tangent(raw):
    """[m] OpenKinect wiki, Imaging Information: Magnenat's fit to a unit of his own."""
    return np.where(raw < 2047, 0.1236 * np.tan(raw / 2842.5 + 1.1863), np.nan)


DEVICE = {
    "reg_info": {"zero_plane_info": {"dcmos_emitter_distance": 7.9, "dcmos_rcmos_distance": 2.4,
                                     "reference_distance": 118.0, "reference_pixel_size": 0.105}, "ax": 1},
    "const_shift": 204,
}  # fmt: skip


def test_fakenect_of_a_unit_that_tells_its_reference_plane(tmp_path):
    (tmp_path / "d-1.5-7.pgm").write_bytes(b"P5 4 1 65535\n" + np.array([600, 700, 800, 2047], "<u2").tobytes())
    (tmp_path / "INDEX.txt").write_text("d-1.5-7.pgm\n")
    camera = Camera(4, 1, 575.0, 575.0, 1.5, 0.0)
    (usual,) = open_recording(tmp_path, camera).warnings
    assert "usual Kinect v1" in usual
    (tmp_path / "device.json").write_text(json.dumps(DEVICE))
    recording = open_recording(tmp_path, camera)
    # freenect_raw_to_mm of libfreenect's registration.c, its lines one after the other
    raw = np.array([600, 700, 800])
    fixed_ref_x = (raw - 4 * 204) / 4 - 0.375
    metric = fixed_ref_x * 0.105
    millimetres = 10 * (metric * 118.0 / (7.9 - metric) + 118.0)
    np.testing.assert_allclose(recording[0].depth[0, :3], millimetres / 1000, rtol=1e-6)
    assert np.isnan(recording[0].depth[0, 3]) and not recording.warnings


def test_a_device_json_that_is_of_no_kinect_is_told(tmp_path):
    (tmp_path / "d-1.5-7.pgm").write_bytes(b"P5 4 1 65535\n" + np.array([600, 700, 800, 2047], "<u2").tobytes())
    (tmp_path / "INDEX.txt").write_text("d-1.5-7.pgm\n")
    (tmp_path / "device.json").write_text(json.dumps(DEVICE | {"const_shift": -3}))
    with pytest.raises(RecordingError, match=r"const_shift.*take device.json away"):
        open_recording(tmp_path)


def test_plain_tum_without_camera_says_what_to_pass(tmp_path):
    plain_tum(tmp_path / "r")
    with pytest.raises(RecordingError, match=r"--camera.*tum-fr1"):
        open_recording(tmp_path / "r")
    assert open_recording(tmp_path / "r", "tum-fr1").camera.depth_scale == 5000
    # four numbers say no unit: it is that of the benchmark
    assert open_recording(tmp_path / "r", "517,516,318,255").camera.depth_scale == 5000
    with pytest.raises(RecordingError, match="tum-fr1"):
        open_recording(tmp_path / "r", "tum-fr9")


def test_what_is_no_recording_is_named(tmp_path):
    (tmp_path / "photos").mkdir()
    write_recording(tmp_path / "scan", synthetic.CAMERA, FRAMES)
    with pytest.raises(RecordingError, match=r"photos/, scan/.*recordings inside: scan/"):
        open_recording(tmp_path)
    with pytest.raises(RecordingError, match="nothing"):
        open_recording(tmp_path / "nowhere")
    with pytest.raises(RecordingError, match="empty folder"):
        open_recording(tmp_path / "photos")


def test_four_numbers_go_with_the_size_of_the_images(tmp_path):
    given = seven_scenes(tmp_path)  # 160 x 120, not the data set's 640 x 480
    camera = open_recording(tmp_path, f"{given.fx},{given.fy},{given.cx},{given.cy}").camera
    assert (camera.width, camera.height) == (160, 120) and camera.fx == given.fx


@pytest.mark.parametrize("part", ["scene_camera.json", "depth"])
def test_a_part_of_a_recording_names_it(tmp_path, part):
    """What shells make of "scan/*"; a folder of images is opened as it is where its camera is said."""
    bop(tmp_path / "scan")
    with pytest.raises(RecordingError, match=r"part of a recording.*name the recording: .*scan$"):
        open_recording(tmp_path / "scan" / part)
    if part == "depth":
        assert len(open_recording(tmp_path / "scan" / part, camera=synthetic.CAMERA)) == 3
