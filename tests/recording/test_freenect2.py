"""Bare depth images of libfreenect2, as its frames lie in memory: float32 millimetres, mirrored, no header."""

import numpy as np
import pytest
import rendered

from fusion import convert_recording, open_recording
from fusion.errors import RecordingError
from fusion.geometry.trajectory import Trajectory

LENS = (365.0, 366.0, 250.0, 210.0)  # fx, fy, cx, cy [px] from the corner, of the picture as a person sees it
CLOSE = 0.15e-3  # as of phones: 0.2 px are more


def dumps(folder, ending=".bin"):
    folder.mkdir(parents=True)
    faces = []
    for i, T in enumerate(rendered.cameras()):
        z, face = rendered.depth(T, 512, 424, *LENS)
        faces.append(face)
        (folder / f"depth_{i + 8}{ending}").write_bytes((1000 * z).astype("<f4")[:, ::-1].tobytes())
    return faces


@pytest.mark.parametrize("place", ["", "depth"])
def test_scene_has_its_size_and_hand(tmp_path, place):
    faces = dumps(tmp_path / "x" / place, ".raw")
    recording = open_recording(tmp_path / "x", "365,366,249.5,209.5")
    assert recording.format == "libfreenect2" and recording.camera.shape == (424, 512)
    poses = rendered.cameras() @ np.diag([1.0, -1, -1, 1])
    placed = type(recording)(**{**vars(recording), "poses": Trajectory(recording.timestamps, poses)})
    worst = np.abs(rendered.errors(placed, faces))
    assert len(worst) >= 12 and worst.max() < CLOSE
    assert any("mirrored" in told for told in recording.warnings)
    convert_recording(recording, tmp_path / "native")
    again = open_recording(tmp_path / "native")[1].depth
    np.testing.assert_allclose(again, recording[1].depth, atol=0.11e-3)  # 0.2 mm a count


def test_without_a_camera_the_nominal_one_is_turned_too(tmp_path):
    dumps(tmp_path / "x")
    recording = open_recording(tmp_path / "x")
    assert recording.camera.cx == pytest.approx(511 - 254.878) and recording.camera.principle == "itof"
    assert any("nominal Kinect v2" in told for told in recording.warnings)


def test_other_files_of_this_size_are_no_depth(tmp_path):
    random = np.random.default_rng(0)
    infrared = random.gamma(1.0, 300.0, (424, 512)).astype("<f4")
    for name, data in {"ir": infrared.tobytes(), "noise": random.bytes(infrared.nbytes), "none": bytes(868352)}.items():
        (tmp_path / name).mkdir()
        (tmp_path / name / "0.bin").write_bytes(data)
        with pytest.raises(RecordingError, match="no recording"):
            open_recording(tmp_path / name)


def test_a_frame_that_was_cut_is_told(tmp_path):
    dumps(tmp_path / "x")
    recording = open_recording(tmp_path / "x")
    path = tmp_path / "x" / "depth_9.bin"
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(RecordingError, match=r"depth_9.bin.*1000 bytes"):
        recording[1]
