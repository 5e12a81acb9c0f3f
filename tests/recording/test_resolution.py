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
