"""Recordings by RealSense's own recorders (tools/formats/samples/realsense.py): .bag of SDK 2.56, .db3 of SDK 2.59."""

import shutil
from pathlib import Path

import box_scene
import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.recording.looking.inspect import inspect
from fusion.recording.open import open_recording

HERE = Path(__file__).parent
SAMPLES = ["realsense_2_56.bag", "realsense_2_59.db3"]
LENGTHS, COLOR_LENGTHS = (55.0, 56.0, 31.25, 23.5), (50.0, 51.0, 27.75, 19.5)
# rays of the colour camera by the SDK's rs2_deproject_pixel_to_point
SDK_RAYS = {
    (0, 0): (-0.5468596, -0.3779165, 1.0),
    (55, 3): (0.5387671, -0.3203752, 1.0),
    (10, 39): (-0.3493031, 0.3759777, 1.0),
    (30, 20): (0.0449968, 0.0097985, 1.0),
    (50, 35): (0.4391243, 0.2991616, 1.0),
}


@pytest.fixture(params=SAMPLES)
def recording(request, tmp_path):
    # by content, not by name
    return open_recording(shutil.copy(HERE / request.param, tmp_path / "recorded"))


def test_scene_in_the_unit_that_the_file_states(recording):
    assert recording.camera.depth_scale == 10000
    np.testing.assert_allclose(recording.camera.parameters, [*LENGTHS, *[0] * 8])
    assert len(recording) == 3
    for index, frame in enumerate(recording):
        expected = box_scene.depth(recording.camera.rays().astype(float), index)
        np.testing.assert_allclose(frame.depth, expected, atol=0.51e-4)  # half a count of 0.1 mm


def test_clock_is_the_device_s(recording):
    # the .bag keeps nanoseconds, the .db3 six decimals of a millisecond
    np.testing.assert_allclose(recording.timestamps, 1 + 0.03325 * np.arange(3), atol=1e-6)


def test_device_is_named(recording):
    camera = recording.camera
    assert (camera.sensor, camera.serial, camera.principle) == ("Intel RealSense D405", "0123", "active_stereo")


def test_colour_keeps_its_place_and_pixels(recording):
    c, s = np.cos(0.1), np.sin(0.1)
    expected = [[c, -s, 0, 0.015], [s, c, 0, 0.001], [0, 0, 1, 0.0002], [0, 0, 0, 1]]
    # the .db3 writes six decimals
    np.testing.assert_allclose(recording.camera.T_color_depth, expected, atol=1e-6)
    for index in range(len(recording)):
        np.testing.assert_array_equal(recording.color_apart(index), box_scene.color(56, 40, index))


def test_lens_is_that_of_the_sdk(recording):
    color: Camera = recording.camera.color
    np.testing.assert_allclose(color.parameters[:4], COLOR_LENGTHS)
    found = color.project(np.array(list(SDK_RAYS.values())))
    # its tangential terms stand on coordinates that the radial ones have moved: two thousandths of a pixel here
    np.testing.assert_allclose(found, np.array(list(SDK_RAYS)), atol=0.005)


def test_the_doctor_finds_nothing_wrong(recording):
    found = inspect(recording)
    assert found.severity == "ok", [finding.seen for finding in found.findings]
    assert found.to_dict()["color_frames"] == 3


def test_another_camera_does_not_change_the_unit(tmp_path):
    mine = Camera(64, 48, 54.0, 54.0, 31.0, 23.0)
    recording = open_recording(HERE / SAMPLES[0], mine)
    assert recording.camera.fx == 54 and recording.camera.depth_scale == 10000
    assert "own unit" in recording.warnings[0]
