"""A voxel size that suits nothing that the frames show is told before the work."""

from pathlib import Path

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.recording.looking.sample import draw
from fusion.recording.recording import Frame, Recording
from fusion.volume.voxel_check import voxel_check

CAMERA = Camera(160, 120, 130.0, 130.0, 79.5, 59.5, depth_scale=5000.0)


@pytest.mark.parametrize(
    ("voxel", "expected"),
    [(None, []), (2.0, ["error"]), (0.2, ["warning"]), (0.05, []), (0.002, []), (0.00005, ["warning"])],
)
def test_voxels_of_a_wall_at_a_metre(voxel, expected):
    # 1.1 m of it are seen without the outer twentieths, 7.7 mm by each pixel
    wall = np.ones(CAMERA.shape, np.float32)
    sample = draw(Recording(Path("made"), "made", CAMERA, np.arange(3.0), lambda i: Frame(i, float(i), wall)))
    assert [finding.severity for finding in voxel_check(voxel)(sample)] == expected
