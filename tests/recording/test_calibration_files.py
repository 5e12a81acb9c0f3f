"""Cameras in the files of programs that calibrate, as these write them."""

import cv2
import numpy as np
import pytest
import synthetic

from fusion.errors import RecordingError
from fusion.recording.cameras.presets import find_camera
from fusion.recording.open import open_recording
from fusion.recording.writing.write import write_recording

KALIBR = """cam0:
  cam_overlaps: []
  camera_model: pinhole
  distortion_coeffs: [-0.011, 0.005, -0.0003, -0.0009]
  distortion_model: radtan
  intrinsics: [641.14, 643.23, 631.5, 365.4]
  resolution: [1280, 720]
  rostopic: /cam0/image_raw
"""
ECHO = """header:
  seq: 3
  frame_id: "depth"
height: 480
width: 640
distortion_model: "plumb_bob"
D: [0.1, -0.2, 0.001, 0.002, 0.05]
K: [575.8, 0.0, 314.5, 0.0, 576.1, 235.5, 0.0, 0.0, 1.0]
R: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
P: [575.8, 0.0, 314.5, 0.0, 0.0, 576.1, 235.5, 0.0, 0.0, 0.0, 1.0, 0.0]
binning_x: 0
binning_y: 0
roi: {x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: False}
---
header:
  seq: 4
"""
OST = """image_width: 640
image_height: 480
camera_name: narrow
camera_matrix:
  rows: 3
  cols: 3
  data: [575.8, 0.     , 314.5,
           0.     , 576.1, 235.5,
           0.     , 0.     , 1.     ]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0.1, -0.2, 1e-05, 0.000000, 0.000000]
"""
ORB_SLAM = """%YAML:1.0

#-----
Camera.type: "PinHole"
Camera.fx: 517.3
Camera.fy: 516.4
Camera.cx: 318.6
Camera.cy: 255.3
Camera.k1: 0.26
Camera.k2: -0.95
Camera.p1: -0.005
Camera.p2: 0.002
Camera.width: 640
Camera.height: 480
DepthMapFactor: 5000.0
"""


def camera_in(folder, text, name="camera.yaml"):
    (folder / name).write_text(text)
    return find_camera(folder / name)


def numbers(camera):
    return camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy


def test_kalibrs_chain_of_one_camera(tmp_path):
    found = camera_in(tmp_path, KALIBR)
    assert numbers(found) == (1280, 720, 641.14, 643.23, 631.5, 365.4)
    assert found.distortion[:4] == (-0.011, 0.005, -0.0003, -0.0009)
    fish = camera_in(tmp_path, KALIBR.replace("radtan", "equidistant").replace("[-0.011", "[0.011"))
    rays = np.array([[0.3, 0.1, 1.0]])
    angle = np.arctan(np.hypot(0.3, 0.1))  # Kannala and Brandt: the angle's own polynomial
    bent = angle * (1 + 0.011 * angle**2 + 0.005 * angle**4 - 0.0003 * angle**6 - 0.0009 * angle**8)
    expected = [641.14 * bent * 0.3 / np.hypot(0.3, 0.1) + 631.5, 643.23 * bent * 0.1 / np.hypot(0.3, 0.1) + 365.4]
    np.testing.assert_allclose(fish.project(rays)[0], expected, atol=0.05)


@pytest.mark.parametrize("text", [ECHO, OST], ids=["echo", "ost"])
def test_ros_camera(tmp_path, text):
    found = camera_in(tmp_path, text, "ost.yml")
    assert numbers(found) == (640, 480, 575.8, 576.1, 314.5, 235.5)
    assert found.distortion[:2] == (0.1, -0.2)
    assert found.distortion[2] == (1e-5 if text is OST else 0.001)  # 1e-05 is text to YAML


@pytest.mark.parametrize("ending", ["yaml", "yml", "xml"])
def test_what_opencv_writes(tmp_path, ending):
    path = tmp_path / f"calibration.{ending}"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", 640)
    storage.write("image_height", 480)
    storage.write("camera_matrix", np.array([[575.8, 0, 314.5], [0, 576.1, 235.5], [0, 0, 1]]))
    storage.write("distortion_coefficients", np.array([[0.1, -0.2, 0.001, 0.002, 0.05]]))
    storage.release()
    found = find_camera(path)
    assert numbers(found) == (640, 480, 575.8, 576.1, 314.5, 235.5)
    assert found.distortion[:5] == (0.1, -0.2, 0.001, 0.002, 0.05)


def test_settings_of_orb_slam_say_the_unit_too(tmp_path):
    found = camera_in(tmp_path, ORB_SLAM)
    assert numbers(found) == (640, 480, 517.3, 516.4, 318.6, 255.3)
    assert (found.depth_scale, found.distortion[:4]) == (5000.0, (0.26, -0.95, -0.005, 0.002))


def test_a_recording_is_opened_with_it(tmp_path):
    write_recording(tmp_path / "r", synthetic.CAMERA, synthetic.frames(2))
    camera = synthetic.CAMERA
    matrix = [camera.fx + 1, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0]
    text = f"image_width: {camera.width}\nimage_height: {camera.height}\ncamera_matrix: {{data: {matrix}}}\n"
    (tmp_path / "ost.yaml").write_text(text)
    assert open_recording(tmp_path / "r", tmp_path / "ost.yaml").camera.fx == camera.fx + 1


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (KALIBR + KALIBR.replace("cam0", "cam1"), "several cameras.*cam0 .*cam1"),
        (KALIBR.replace("pinhole", "omni"), "camera model is not known.*omni"),
        (KALIBR.replace("radtan", "fov"), "lens model is not known.*fov"),
        (KALIBR.replace("641.14", ".nan"), "cam0.intrinsics .*nan"),
        (KALIBR.replace("641.14, ", ""), "cam0.intrinsics .*3 numbers"),
        (KALIBR.replace("[1280, 720]", "[1280]"), "cam0.resolution"),
        (OST.replace("image_width: 640\n", ""), "image_width, image_height .*nothing"),
        (OST.replace("575.8, 0.     ,", "575.8,"), "8 numbers"),
        (ORB_SLAM.replace("5000.0", "0.0"), "depth scale"),
        (ORB_SLAM.replace("517.3", "-517.3"), "camera cannot be used"),
        ("a: &a [1, 1]\nb: &b [*a, *a]\nK: *b\n", "only named"),
        ("%YAML:1.0\n---\ncamera_matrix: !!opencv-matrix\n   data: [1, 2", "broken"),
        ("cam0: [1, 2\n  x: }", "no YAML"),
        ("[" * 3000, "no YAML"),
        ("hello", "no camera that is known"),
        ("", "no camera that is known"),
        ("name: chair\n", "no camera that is known.*name"),
    ],
)
def test_what_cannot_be_used_is_told_in_one_line(tmp_path, text, told):
    with pytest.raises(RecordingError, match=told) as caught:
        camera_in(tmp_path, text)
    assert "\n" not in str(caught.value)
