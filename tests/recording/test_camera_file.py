"""Camera files of every format: read as they are, or refused with key, finding, bounds and unit."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
import synthetic

from fusion.errors import RecordingError
from fusion.recording.cameras.presets import find_camera
from fusion.recording.formats import bop, open3d_folder
from fusion.recording.native.camera_file import camera_content, camera_of, camera_to_dict, read_camera, write_camera

PLAIN = camera_to_dict(synthetic.CAMERA)
FULL = replace(
    synthetic.CAMERA,
    distortion=(0.1, -0.2, 0.0, 0.0, 0.3, 0.1, 0.2, 0.3),
    serial="a1",
    std={"fx": 0.1},
    color=replace(synthetic.CAMERA, fx=600.0),
    T_color_depth=np.eye(4),
)

WRONG = [
    ({"fx": ...}, '"fx" of the camera cannot be used; .*found nothing; expected a number from 0.01'),
    ({"fx": 0}, r"found 0; expected a number from 0.01 to 1e6 .*\[px\].*--camera"),
    ({"fx": 1e-300}, "found 1e-300; expected a number from 0.01 to 1e6"),
    ({"fx": 1e7}, r"expected a number from 0.01 to 1e6"),
    ({"cx": 10**400}, '"cx" of the camera'),
    ({"width": 640.5}, "expected a whole number from 1 to 65535"),
    ({"depth_scale": 1e-300}, r"found 1e-300; expected a number from 0.001 to 1e7 \(counts per metre"),
    ({"depth_scale": 1e300}, "counts per metre"),
    ({"principle": "laser"}, 'one of .*"structured_light"'),
    ({"distortion": [0.1, 0.2]}, "OpenCV's 4, 5 or 8 finite numbers"),
    ({"distortion": [0.1, 0.2, 0, "0"]}, "OpenCV's 4, 5 or 8 finite numbers"),
    ({"std": {"fx": 1, "cy": -1}}, r'"std\.cy" of the camera .*of at least 0'),
    ({"color": PLAIN | {"fy": -1}}, r'"color\.fy" of the camera'),
    ({"color": PLAIN | {"T_color_depth": np.diag([2.0, 2, 2, 1]).tolist()}}, "a rigid 4x4 matrix, metres"),
    ({"color": PLAIN | {"T_color_depth": [[1, 0], [0, 1]]}}, "a rigid 4x4 matrix, metres"),
]


@pytest.mark.parametrize(("change", "said"), WRONG, ids=[str(change)[:40] for change, _ in WRONG])
def test_a_wrong_field_is_told_with_its_bounds(change, said):
    fields = {key: value for key, value in (PLAIN | change).items() if value is not ...}
    with pytest.raises(RecordingError, match=said) as caught:
        camera_of(camera_content(fields, "there/camera.json"))
    assert "there/camera.json" in str(caught.value) and "\n" not in str(caught.value)


def test_a_camera_is_read_as_it_was_written(tmp_path):
    write_camera(tmp_path / "camera.json", FULL)
    again = read_camera(tmp_path / "camera.json")
    assert camera_to_dict(again) == camera_to_dict(FULL)


def test_what_others_write_is_read_too():
    other = {"width": 160.0, "serial": 4711, "sensor": None, "distortion": None, "std": None, "new": {"x": 1}}
    camera = camera_of(camera_content(PLAIN | other, "camera.json"))
    assert camera.width == 160 and camera.serial == "4711" and camera.sensor == ""


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_a_mark_before_the_text_changes_nothing(tmp_path, encoding):
    (tmp_path / "camera.json").write_text(json.dumps(PLAIN), encoding=encoding)
    assert read_camera(tmp_path / "camera.json").fx == synthetic.CAMERA.fx


OPEN3D = {"width": 6, "height": 4, "intrinsic_matrix": [5.0, 0, 0, 0, 5.0, 0, 3.0, 2.0, 1]}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (json.dumps(OPEN3D).replace("6", "9" * 400), '"width" cannot be used.*finite'),
        (json.dumps(OPEN3D | {"intrinsic_matrix": [5.0, 0]}), '"intrinsic_matrix" of the camera.*column by column'),
        (json.dumps(OPEN3D | {"intrinsic_matrix": [0] * 9}), "focal lengths from 0.01"),
        (json.dumps(OPEN3D | {"height": 0}), '"height" of the camera.*whole number'),
    ],
)
def test_open3d_cameras_are_refused_in_one_line(tmp_path, text, said):
    (tmp_path / "intrinsic.json").write_text(text)
    with pytest.raises(RecordingError, match=said):
        open3d_folder.camera_in(tmp_path)


def test_open3d_matrices_come_flat_or_in_columns(tmp_path):
    for matrix in (OPEN3D["intrinsic_matrix"], [[5.0, 0, 0], [0, 5.0, 0], [3.0, 2.0, 1]]):
        (tmp_path / "intrinsic.json").write_text(json.dumps(OPEN3D | {"intrinsic_matrix": matrix}))
        camera = open3d_folder.camera_in(tmp_path)
        assert (camera.width, camera.fx, camera.cx, camera.cy) == (6, 5.0, 3.0, 2.0)


K = [5.0, 0, 3.0, 0, 5.0, 2.0, 0, 0, 1]


@pytest.mark.parametrize("sides", [[6, 4], [4, 6]])
@pytest.mark.parametrize("matrix", [K, [K[:3], K[3:6], K[6:]]])
def test_a_matrix_with_a_resolution_in_either_order(tmp_path, sides, matrix):
    (tmp_path / "camera_intrinsic.json").write_text(json.dumps({"K": matrix, "resolution": sides}))
    camera = open3d_folder.camera_in(tmp_path)
    assert (camera.width, camera.height, camera.fx, camera.cx) == (6, 4, 5.0, 3.0)
    assert find_camera(tmp_path / "camera_intrinsic.json") == camera


@pytest.mark.parametrize(
    ("entries", "said"),
    [
        ({"K": K}, '"resolution".*nothing'),
        ({"K": [1.0] * 9, "resolution": [6, 4]}, '"K" of the camera.*row by row'),
        ({"K": K, "resolution": [6, -4]}, '"resolution".*-4'),
    ],
)
def test_a_matrix_that_is_no_camera_is_refused_in_one_line(tmp_path, entries, said):
    (tmp_path / "intrinsic.json").write_text(json.dumps(entries))
    with pytest.raises(RecordingError, match=said):
        open3d_folder.camera_in(tmp_path)


@pytest.mark.parametrize(
    ("entries", "said"),
    [
        ({"0": {}}, '"0.cam_K" of the scene cannot be used.*found nothing; expected 9 numbers'),
        ({"0": {"cam_K": K, "depth_scale": 0}}, '"0.depth_scale".*millimetres per count'),
        ({"0": {"cam_K": K}, "1": {"cam_K": K, "depth_scale": 0.1}}, '"1.depth_scale".*that of the first'),
        ({"0": {"cam_K": K, "cam_R_w2c": [1] * 9, "cam_t_w2c": [0, 0, 0]}}, '"0.cam_R_w2c".*a rotation'),
        ({"one": {"cam_K": K}}, '"one" of the scene.*the number of an image'),
    ],
)
def test_bop_cameras_are_refused_in_one_line(tmp_path, entries, said):
    (tmp_path / "scene_camera.json").write_text(json.dumps(entries))
    (tmp_path / "depth").mkdir()
    for name in entries:
        (tmp_path / "depth" / f"{name:0>6}.png").write_bytes(cv2.imencode(".png", np.ones((4, 6), np.uint16))[1])
    with pytest.raises(RecordingError, match=said):
        bop.read(tmp_path, synthetic.CAMERA if "cam_R" in said else None)
