"""Frames without a colour image are told by `fusion info`, whatever the format."""

import zipfile

import numpy as np
import pytest
import test_phones

from fusion import Camera, Frame, inspect, open_recording, write_recording


def _told(recording):
    return [f for f in inspect(recording).findings if "have no colour image" in f.seen]


@pytest.mark.parametrize("lost", [1, 12])
def test_in_a_native_folder(tmp_path, lost):
    depth, color = np.full((48, 64), 1.2, np.float32), np.full((48, 64, 3), 90, np.uint8)
    frames = [Frame(i, i / 30, depth, None if i < lost else color) for i in range(40)]
    write_recording(tmp_path / "x", Camera(64, 48, 60.0, 60.0, 31.5, 23.5), frames)
    (finding,) = _told(open_recording(tmp_path / "x"))
    assert finding.severity == "ok" and finding.seen.startswith(f"{lost} of 40 frames")


def test_in_an_archive_of_a_phone(tmp_path):
    whole, less = test_phones.record3d(tmp_path / "x", test_phones.Scene()), tmp_path / "y"
    assert not _told(open_recording(whole))
    with zipfile.ZipFile(whole) as old, zipfile.ZipFile(less, "w") as new:
        for name in old.namelist():
            if name != "rgbd/1.jpg":
                new.writestr(name, old.read(name))
    (finding,) = _told(open_recording(less))
    assert finding.seen == "1 of 3 frames have no colour image"


def test_without_any_colour_there_is_nothing_to_miss(tmp_path):
    depth = np.full((48, 64), 1.2, np.float32)
    write_recording(tmp_path / "x", Camera(64, 48, 60.0, 60.0, 31.5, 23.5), (Frame(i, i / 30, depth) for i in range(3)))
    assert not _told(open_recording(tmp_path / "x"))
