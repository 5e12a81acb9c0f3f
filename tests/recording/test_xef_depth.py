"""What XEFExtract takes out of a `.xef`, written as its own source lays it out: size, hand, cuts."""

import struct

import numpy as np
import pytest
import rendered

from fusion import convert_recording, open_recording
from fusion.geometry.trajectory import Trajectory

LENS = (365.0, 366.0, 250.0, 210.0)  # fx, fy, cx, cy [px] from the corner, of the picture as a person sees it
CLOSE = 0.15e-3  # as of phones: 0.2 px are more


def extracted(path, claimed=3):
    """XEFDepthWriter: long, three uints; then a long and the frame's shorts, mirrored."""
    faces = []
    with path.open("wb") as file:
        file.write(struct.pack("<qIII", claimed, 512, 424, 512 * 424 * 2))
        for i, T in enumerate(rendered.cameras()):
            z, face = rendered.depth(T, 512, 424, *LENS)
            faces.append(face)
            file.write(struct.pack("<q", i) + np.rint(1000 * z).astype("<u2")[:, ::-1].tobytes())
    return faces


@pytest.mark.parametrize("claimed", [3, 0])  # 0: the tool was stopped
def test_scene_has_its_size_and_hand(tmp_path, claimed):
    faces = extracted(tmp_path / "room_Depth.dat", claimed)
    recording = open_recording(tmp_path / "room_Depth.dat", "365,366,249.5,209.5")
    assert recording.format == "xef-depth" and recording.camera.shape == (424, 512) and len(recording) == 3
    poses = rendered.cameras() @ np.diag([1.0, -1, -1, 1])
    placed = type(recording)(**{**vars(recording), "poses": Trajectory(recording.timestamps, poses)})
    worst = np.abs(rendered.errors(placed, faces))
    assert len(worst) >= 12 and worst.max() < CLOSE
    assert any("mirrored" in told for told in recording.warnings)
    convert_recording(recording, tmp_path / "native")
    np.testing.assert_array_equal(open_recording(tmp_path / "native").depth_counts(1), recording.depth_counts(1))


def test_nominal_camera_and_cuts(tmp_path):
    path = tmp_path / "room_Depth.dat"
    extracted(path)
    recording = open_recording(path)
    assert recording.camera.cx == pytest.approx(511 - 254.878) and recording.camera.principle == "itof"
    path.write_bytes(path.read_bytes()[:-1000])
    recording = open_recording(path)
    assert len(recording) == 2 and any("2 of 3 frames are whole" in told for told in recording.warnings)
