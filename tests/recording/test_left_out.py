"""What is left out of a recording is named, whatever is done with it."""

import logging

import cv2
import numpy as np
import pytest
import synthetic

from fusion.commands.main import main
from fusion.errors import RecordingError
from fusion.recording.open import open_recording
from fusion.recording.writing.convert import convert_recording
from fusion.recording.writing.write import write_recording


@pytest.fixture
def folder(tmp_path):
    write_recording(tmp_path / "r", synthetic.CAMERA, synthetic.frames(3, color=True, ir=True))
    return tmp_path / "r"


def resized(path):
    cv2.imwrite(str(path), np.zeros((60, 80), np.uint16 if "ir" in path.parts else np.uint8))


def test_images_of_a_frame_that_was_cut_off_before_its_depth_are_no_loss(folder):
    """Depth is listed last, so a recorder that is killed may leave one frame's other images behind."""
    lines = (folder / "depth.txt").read_text().splitlines()
    (folder / "depth.txt").write_text("\n".join([*lines[:-1], ""]))
    recording = open_recording(folder)
    assert len(recording) == 2 and not recording.warnings


def test_convert_names_an_image_that_belongs_to_no_frame(folder, caplog):
    """Its frame is converted without: a stamp that is a second off, a name that nobody meant."""
    lines = (folder / "rgb.txt").read_text().splitlines()
    (folder / "rgb.txt").write_text("\n".join([*lines[:-1], "500.0 rgb/000002.png", ""]))
    notes: list[str] = []
    convert_recording(open_recording(folder), folder.parent / "a", notes)
    assert notes == ["1 of 3 images of rgb.txt have no depth frame within 0.02 s"]
    assert main(["convert", str(folder), str(folder.parent / "b")]) == 0
    assert [r.getMessage() for r in caplog.records if r.levelno == logging.WARNING] == [f"{folder}: {notes[0]}"]


def test_an_image_of_another_size_is_named(folder):
    resized(folder / "rgb/000001.png")
    frame = open_recording(folder)[1]
    assert frame.unfit == ("color",) and frame.color is None and frame.ir is not None
    notes: list[str] = []
    convert_recording(open_recording(folder), folder.parent / "a", notes)
    assert notes == ["1 color images are not in the depth camera's pixels: left out"]


def test_a_mesh_that_is_not_there_is_named(folder):
    (folder / "scene.json").write_text('{"mesh": "chair.ply"}')
    notes: list[str] = []
    convert_recording(open_recording(folder), folder.parent / "a", notes)
    assert notes == ["the mesh of the scene is not there: chair.ply"]


def test_a_mesh_that_is_no_file_is_refused(folder):
    (folder / "scene.json").write_text('{"mesh": "chair.ply"}')
    (folder / "chair.ply").mkdir()
    with pytest.raises(RecordingError, match="the mesh of the scene is no file"):
        convert_recording(open_recording(folder), folder.parent / "a")


def test_an_endless_value_of_a_log_is_named(folder):
    (folder / "telemetry.csv").write_text("timestamp,turntable_deg\n100,0\n100.1,nan\n100.2,\n100.3,inf\n")
    (warning,) = [text for text in open_recording(folder).warnings if "turntable_deg" in text]
    lost = "2 of 4 values of turntable_deg in telemetry.csv are left out"
    assert warning == f"{lost}: no finite numbers, the first in line 3"


def test_infrared_of_another_camera_is_left_out_with_a_warning(folder):
    for path in (folder / "ir").iterdir():
        resized(path)
    recording = open_recording(folder)
    assert recording[0].ir is None and recording.warnings == (
        "infrared is not in the depth camera's pixels and left out: its images are 80 x 60, the depth images 160 x 120",
    )


def test_the_scene_of_every_format_is_looked_at(tmp_path):
    """A mesh that would take the place of a part of the recording, beside a list of another format than the native."""
    folder = tmp_path / "chess"
    folder.mkdir()
    cv2.imwrite(str(folder / "frame-000000.depth.png"), np.full((480, 640), 1000, np.uint16))
    np.savetxt(folder / "frame-000000.pose.txt", np.eye(4))
    (folder / "telemetry.csv").write_text("mine")
    (folder / "scene.json").write_text('{"mesh": "telemetry.csv"}')
    recording = open_recording(folder, "7scenes")
    assert recording.format == "7scenes" and recording.scene == {"mesh": "telemetry.csv"}
    with pytest.raises(RecordingError, match="the mesh of the scene is a part of the recording"):
        convert_recording(recording, tmp_path / "out")
