"""Cameras as scripts write them down: other names, metres per count, a lens in single letters, several cameras."""

import json

import cv2
import numpy as np
import pytest

from fusion.errors import RecordingError
from fusion.recording.cameras.presets import find_camera
from fusion.recording.open import open_recording

REALSENSE = {"fx": 610.0, "fy": 608.7, "ppx": 318.5, "ppy": 247.6, "height": 480, "width": 640}
MATRIX = [[600.0, 0, 320], [0, 601, 240], [0, 0, 1]]
SIZE = {"width": 640, "height": 480}


def camera_of(tmp_path, fields):
    path = tmp_path / "intrinsics.json"
    path.write_text(json.dumps(fields))
    return find_camera(path)


@pytest.mark.parametrize(
    ("said", "counts"), [(0.0010000000474974513, 1000), (0.0002500000118743628, 4000), (5000, 5000)]
)
def test_realsense_names_and_metres_per_count(tmp_path, said, counts):
    found = camera_of(tmp_path, REALSENSE | {"depth_scale": said})
    assert (found.shape, found.fx, found.fy, found.cx, found.cy) == ((480, 640), 610.0, 608.7, 318.5, 247.6)
    assert found.depth_scale == counts and not any(found.distortion)


def test_metres_per_count_are_told_from_counts_per_metre_in_a_camera_file_too(tmp_path):
    fields = SIZE | {"fx": 600.0, "fy": 600.0, "cx": 320.0, "cy": 240.0}
    assert camera_of(tmp_path, fields | {"depth_scale": 0.001}).depth_scale == 1000
    assert camera_of(tmp_path, fields | {"depth_scale": 1000}).depth_scale == 1000


LENS = [-0.45, 0.23, 0.002, 0.001, -0.02]


@pytest.mark.parametrize(
    "fields",
    [
        {"matrix": MATRIX, "distortion": [LENS]},
        {"K": MATRIX, "dist": LENS},
        {"camera_matrix": {"rows": 3, "cols": 3, "data": [600.0, 0, 320, 0, 601, 240, 0, 0, 1]}, "dist_coeffs": [LENS]},
        {"fx": 600, "fy": 601, "cx": 320, "cy": 240} | dict(zip(("k1", "k2", "p1", "p2", "k3"), LENS, strict=True)),
        {"fl_x": 600, "fl_y": 601, "cx": 320, "cy": 240} | dict(zip(("k1", "k2", "p1", "p2", "k3"), LENS, strict=True)),
        {"fx": 600, "fy": 601, "ppx": 320, "ppy": 240, "model": 2, "coeffs": LENS},
        {"fx": 600, "fy": 601, "ppx": 320, "ppy": 240, "model": "distortion.inverse_brown_conrady", "coeffs": LENS},
    ],
)
@pytest.mark.parametrize("inside", ["", "depth_intrinsics"])
def test_matrices_and_lenses_under_their_usual_names(tmp_path, fields, inside):
    fields = fields | SIZE
    found = camera_of(tmp_path, {inside: fields, "serial": "17"} if inside else fields)
    assert (found.shape, found.fx, found.fy, found.cx, found.cy) == ((480, 640), 600, 601, 320, 240)
    assert found.distortion[:5] == tuple(LENS)


@pytest.mark.parametrize(
    ("fields", "told"),
    [
        (
            {"color": REALSENSE, "depth": REALSENSE | {"fx": 383.26}},
            "several cameras.*color: 610.00.*depth: 383.26,608.70",
        ),
        ({"matrix": MATRIX, "dist": LENS}, "image_width, image_height .*nothing.*add it"),
        (SIZE | {"matrix": MATRIX[:2]}, "6 numbers"),
        (SIZE | {"matrix": MATRIX, "dist": ["a"]}, "distortion_coefficients .*numbers"),
        (REALSENSE | {"fx": []}, "fx of the camera.*a number"),
        (REALSENSE | {"fx": "far"}, "fx of the camera"),
        (REALSENSE | {"fx": -610}, "focal lengths"),
        (REALSENSE | {"depth_scale": 0}, "depth scale.*metres per count"),
        (REALSENSE | {"depth_scale": [[1], [2]]}, "depth_scale"),
        (REALSENSE | {"k1": -0.15, "k2": 0.02, "k3": -0.005, "k4": 0.001}, "lens model is not known.*no p1, p2"),
        (REALSENSE | {"model": 3, "coeffs": LENS}, "lens model is not known.*ftheta"),
        (REALSENSE | {"model": 17, "coeffs": LENS}, "lens model is not known.*number 17"),
        (REALSENSE | {"distortion_model": "fov", "coeffs": LENS}, "lens model is not known.*fov"),
    ],
)
def test_what_cannot_be_used_of_them_is_told(tmp_path, fields, told):
    with pytest.raises(RecordingError, match=told) as caught:
        camera_of(tmp_path, fields)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "model",
    [
        {"distortion_model": "equidistant"}, {"model": 5}, {"model": "distortion.kannala_brandt4"},
        {"camera_model": "OPENCV_FISHEYE"},
    ],
)  # fmt: skip
def test_a_fisheye_is_taken_where_it_says_so(tmp_path, model):
    bent = camera_of(tmp_path, REALSENSE | model | {"coeffs": [0.01, 0.0, 0.0, 0.0]})
    plain = camera_of(tmp_path, REALSENSE | {"model": "D435", "coeffs": [0.01, 0.0, 0.0, 0.0]})
    assert any(bent.distortion) and bent.distortion[:1] != plain.distortion[:1] == (0.01,)


@pytest.mark.parametrize("place", ["", "depth"])
def test_a_camera_that_lies_beside_the_images_is_named(tmp_path, place):
    for name in {place, "color"} if place else {""}:
        (tmp_path / name).mkdir(exist_ok=True)
    cv2.imwrite(str(tmp_path / place / "1.png"), np.full((480, 640), 900, np.uint16))
    with pytest.raises(RecordingError, match=r"640 x 480.*pass --camera fx,fy,cx,cy"):
        open_recording(tmp_path)
    (tmp_path / "broken.json").write_text("{")
    (tmp_path / "intrinsics.json").write_text(json.dumps(REALSENSE))
    with pytest.raises(RecordingError, match=r"640 x 480.*pass --camera .*intrinsics.json if depth is its, or fx,fy"):
        open_recording(tmp_path)
    assert open_recording(tmp_path, tmp_path / "intrinsics.json").camera.fx == 610


@pytest.mark.parametrize("name", ["calib.json", "calib.yaml"])
@pytest.mark.parametrize(
    "fields",
    [{"camera_matrix": MATRIX, "dist_coeff": [LENS]}, {"fx": 600, "fy": 601, "cx": 320, "cy": 240, "k1": -0.45}],
)
def test_a_file_without_a_size_has_that_of_the_images(tmp_path, name, fields):
    cv2.imwrite(str(tmp_path / "1.png"), np.full((480, 640), 900, np.uint16))
    (tmp_path / name).write_text(json.dumps(fields))
    found = open_recording(tmp_path, tmp_path / name)
    assert (found.camera.shape, found.camera.fy, found.camera.distortion[0]) == ((480, 640), 601, -0.45)
    assert np.nanmax(found[0].depth) == pytest.approx(0.9)
    with pytest.raises(RecordingError, match=r"image_width, image_height .*nothing"):
        find_camera(tmp_path / name)


def test_a_camera_file_that_lacks_a_number_is_not_its_colour_camera(tmp_path):
    color = SIZE | {"fx": 600, "fy": 601, "cx": 320, "cy": 240}
    with pytest.raises(RecordingError, match='"fx" of the camera'):
        camera_of(tmp_path, SIZE | {"fy": 365, "cx": 255, "cy": 205, "color": color})


def test_what_lies_beside_images_and_is_no_file_is_passed_over(tmp_path):
    cv2.imwrite(str(tmp_path / "1.png"), np.full((480, 640), 900, np.uint16))
    (tmp_path / "gone.json").symlink_to(tmp_path / "nowhere.json")
    (tmp_path / "folder.yaml").mkdir()
    with pytest.raises(RecordingError, match="no camera"):
        open_recording(tmp_path)


def test_four_numbers_in_a_file_are_enough_too(tmp_path):
    cv2.imwrite(str(tmp_path / "1.png"), np.full((480, 640), 900, np.uint16))
    (tmp_path / "camera.json").write_text(json.dumps({"fx": 600, "fy": 601, "cx": 320, "cy": 240, "sensor": "mine"}))
    found = open_recording(tmp_path, tmp_path / "camera.json").camera
    assert (found.shape, found.sensor) == ((480, 640), "mine")
