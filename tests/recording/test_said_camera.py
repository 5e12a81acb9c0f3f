"""A camera that is said, or lies beside the images: Open3D's file, a fifth number, the matrix of a data set."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
import synthetic
from test_formats import seven_scenes

from fusion.errors import RecordingError
from fusion.recording.cameras.presets import find_camera
from fusion.recording.open import open_recording
from fusion.recording.writing.write import write_recording

MATRIX = "615.2 0 298.4\n0 616.3 247.5\n0 0 1\n"


def test_the_camera_file_of_open3d_is_one(tmp_path):
    path = tmp_path / "rs.json"
    path.write_text(json.dumps({"width": 640, "height": 480, "intrinsic_matrix": [617, 0, 0, 0, 618, 0, 317, 246, 1]}))
    found = find_camera(path)
    assert (found.fx, found.fy, found.cx, found.cy, found.shape) == (617, 618, 317, 246, (480, 640))


def test_a_fifth_number_is_the_counts_per_metre(tmp_path):
    write_recording(tmp_path / "r", synthetic.CAMERA, synthetic.frames(2))
    one = open_recording(tmp_path / "r")
    five = open_recording(tmp_path / "r", f"100,101,20,15,{one.camera.depth_scale / 5:g}")
    assert replace(five.camera, depth_scale=0) == replace(
        open_recording(tmp_path / "r", "100,101,20,15").camera, depth_scale=0
    )
    np.testing.assert_allclose(five[0].depth, 5 * one[0].depth, rtol=1e-6)
    with pytest.raises(RecordingError, match="counts per metre"):
        open_recording(tmp_path / "r", "100,101,20,15,0")


@pytest.mark.parametrize("where", ["seq/intrinsics.K.txt", "camera-intrinsics.txt"])
def test_the_matrix_beside_the_images_of_a_data_set_is_its_camera(tmp_path, where):
    (tmp_path / "seq").mkdir()
    seven_scenes(tmp_path / "seq")
    assert open_recording(tmp_path / "seq").camera.fx == 585
    (tmp_path / where).write_text(MATRIX)
    found = open_recording(tmp_path / "seq")
    assert (found.camera.fx, found.camera.cy) == (615.2, 247.5) and not found.camera.sensor
    assert not any("nominal" in text or "registered" in text for text in found.warnings)
    (tmp_path / where).write_text("615.2 0 298.4\n0 616.3 247.5\n")
    with pytest.raises(RecordingError, match="3 rows of 3"):
        open_recording(tmp_path / "seq")


@pytest.mark.parametrize("place", ["", "depth"])
def test_images_of_a_kind_that_is_not_read_are_named(tmp_path, place):
    (tmp_path / place).mkdir(exist_ok=True)
    (tmp_path / place / "1.exr").write_bytes(b"v/1\1")
    with pytest.raises(RecordingError, match=r"\.exr images as 16-bit PNG"):
        open_recording(tmp_path)


@pytest.mark.parametrize("size", [(320, 240), (160, 120)])
def test_a_preset_is_resized_to_images_in_its_proportion(tmp_path, size):
    width, height = size
    cv2.imwrite(str(tmp_path / "1.png"), np.full((height, width), 900, np.uint16))
    found = open_recording(tmp_path, "primesense")
    share = width / 640
    assert found.camera.fx == 525 * share and found.camera.cx == pytest.approx(320 * share - 0.5)
    assert any("resized from 640 x 480" in text for text in found.warnings)
    assert np.nanmax(found[0].depth) == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("preset", "size", "focal", "middle"),
    [  # as two units state their modes (realsense-ros issue 2788; public code): of 640 x 480, and of half its size
        ("realsense-d435", (640, 480), 384.2 / 424.2 * 425.8, 319.5 + 0.9057 * 3.7),
        ("realsense-d435", (320, 240), 384.2 / 424.2 * 425.8 / 2, (319.5 + 0.9057 * 3.7 + 0.5) / 2 - 0.5),
        ("realsense-d435-color", (640, 480), 618.1 / 927.1 * 917, 319.5),
        ("realsense-d435", (1280, 720), 644.0 / 386.4 * 384.2 / 424.2 * 425.8, None),
    ],
)
def test_images_cut_from_the_same_imager_have_the_focal_length_of_their_mode(tmp_path, preset, size, focal, middle):
    cv2.imwrite(str(tmp_path / "1.png"), np.full((size[1], size[0]), 900, np.uint16))
    found = open_recording(tmp_path, preset)
    assert found.camera.fx == pytest.approx(focal, rel=2e-3) and found.camera.shape == size[::-1]
    assert middle is None or found.camera.cx == pytest.approx(middle, abs=0.1)
    assert np.nanmax(found[0].depth) == pytest.approx(0.9)
    assert any("resized" in text for text in found.warnings) == (size in [(320, 240)])


def test_a_preset_of_another_shape_is_refused(tmp_path):
    cv2.imwrite(str(tmp_path / "1.png"), np.full((240, 424), 900, np.uint16))
    with pytest.raises(RecordingError, match="another size"):
        open_recording(tmp_path, "primesense")[0]
