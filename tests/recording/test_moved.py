"""What a log says was moved: a step of the stated distance is one, the scatter of a laser is none."""

from pathlib import Path

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.recording.looking.moved import unmoved_parts
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording

CAMERA = Camera(32, 24, 30.0, 30.0, 15.5, 11.5, depth_scale=1000)


@pytest.mark.parametrize(
    ("column", "values", "parts"),
    [
        ("distance_m", [1.0, 1.0, 2.0, 2.0], [(0, 2), (2, 4)]),
        # a laser read with every frame scatters by a millimetre or two
        ("distance_m", [1.0, 1.002, 0.999, 1.001], [(0, 4)]),
        # a slow move is cut where it has left its beginning by half a centimetre
        ("distance_m", [1.0, 1.003, 1.006, 1.009], [(0, 2), (2, 4)]),
        ("turntable_deg", [0.0, 0.0, 10.0, 10.0], [(0, 2), (2, 4)]),
    ],
)
def test_parts(tmp_path: Path, column: str, values: list[float], parts: list[tuple[int, int]]) -> None:
    frames = (Frame(i, float(i), np.full(CAMERA.shape, 1.0, np.float32)) for i in range(4))
    write_recording(tmp_path / "r", CAMERA, frames, telemetry={"timestamp": [0.0, 1.0, 2.0, 3.0], column: values})
    assert [(p.start, p.stop) for p in unmoved_parts(open_recording(tmp_path / "r"))] == parts
