"""Sensors of a few pixels are read and shown; a scan with one is refused with the reason."""

import numpy as np
import pytest

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.recording.looking.doctor import quick_look, refuse_if_certain
from fusion.recording.looking.inspect import inspect
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording


def recording(folder, width, height):
    camera = Camera(width, height, width / 0.9, width / 0.9, (width - 1) / 2, (height - 1) / 2)
    frames = (Frame(i, i / 10, np.full((height, width), 0.8 + i / 1000, np.float32)) for i in range(5))
    write_recording(folder, camera, frames)
    return open_recording(folder)


@pytest.mark.parametrize("size", [(8, 8), (32, 24), (60, 45)])
def test_few_pixels_are_shown_but_carry_no_scan(tmp_path, size):
    small = recording(tmp_path / "r", *size)
    found = inspect(small)
    assert found.severity == "warning"
    assert [f.check for f in found.findings if f.severity != "ok"] == ["resolution"]
    with pytest.raises(RecordingError, match=rf"{size[0]} x {size[1]} pixels are too few.*--force"):
        refuse_if_certain(quick_look(small), small)


def test_more_pixels_may(tmp_path):
    assert quick_look(recording(tmp_path / "r", 80, 60)) == []


@pytest.mark.parametrize("step", [2, 4])
def test_depth_laid_on_a_larger_image_is_named(tmp_path, step):
    """Its grid of holes leaves surfaces without normals; a scan was told to move slower."""
    camera = Camera(160, 120, 150.0, 150.0, 79.5, 59.5)
    depth = np.full((120, 160), 0.8, np.float32)
    depth[::step] = depth[:, ::step] = np.nan
    write_recording(tmp_path / "r", camera, [Frame(0, 0.0, depth), Frame(1, 0.1, depth)])
    laid = open_recording(tmp_path / "r")
    assert "neighbours" in [f.check for f in inspect(laid).findings if f.severity == "error"]
    with pytest.raises(RecordingError, match=r"grid of missing pixels.*own pixels"):
        refuse_if_certain(quick_look(laid), laid)


@pytest.mark.parametrize("share", [0.1, 0.4, 0.75])
def test_values_missing_at_random_are_no_grid(tmp_path, share):
    camera = Camera(160, 120, 150.0, 150.0, 79.5, 59.5)
    rng = np.random.default_rng(1)
    depths = [np.where(rng.random((120, 160)) < share, np.nan, 0.8).astype(np.float32) for _ in range(3)]
    write_recording(tmp_path / "r", camera, (Frame(i, i / 10, depth) for i, depth in enumerate(depths)))
    assert not [f for f in quick_look(open_recording(tmp_path / "r")) if f.check == "neighbours"]
