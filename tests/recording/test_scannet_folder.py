"""ScanNet's frames as its SensReader exports them: 4 x 4 poses by number, matrices of both cameras in text files."""

import cv2
import numpy as np
import pytest
import synthetic

from fusion.errors import RecordingError
from fusion.recording.open import open_recording

CAMERA = synthetic.CAMERA
FRAMES = (0, 2, 10)  # counted, not in the order of letters


def exported(folder, size=(160, 120), pose="pose"):
    for name in ("depth", "color", pose, "intrinsic"):
        (folder / name).mkdir(parents=True)
    for n in FRAMES:
        cv2.imwrite(str(folder / f"depth/{n}.png"), np.full((CAMERA.height, CAMERA.width), 900 + n, np.uint16))
        cv2.imwrite(str(folder / f"color/{n}.jpg"), np.full((size[1], size[0], 3), 90, np.uint8))
        T = np.eye(4)
        T[0, 3] = n
        np.savetxt(folder / pose / f"{n}.txt", T, fmt="%f")
    K = np.eye(4)
    K[:3, :3] = [[CAMERA.fx, 0, CAMERA.cx], [0, CAMERA.fy, CAMERA.cy], [0, 0, 1]]
    np.savetxt(folder / "intrinsic/intrinsic_depth.txt", K, fmt="%f")
    K[:2] *= 2
    np.savetxt(folder / "intrinsic/intrinsic_color.txt", K, fmt="%f")


@pytest.mark.parametrize("pose", ["pose", "poses"])
def test_camera_poses_and_colours_are_read(tmp_path, pose):
    exported(tmp_path, (2 * CAMERA.width, 2 * CAMERA.height), pose)
    found = open_recording(tmp_path)
    assert found.camera.shape == CAMERA.shape and found.camera.fx == pytest.approx(CAMERA.fx, abs=1e-5)
    assert found.poses.centres[:, 0].tolist() == list(FRAMES)
    assert found.camera.color.fx == pytest.approx(2 * CAMERA.fx, abs=1e-5)
    assert [round(float(np.nanmax(frame.depth)), 3) for frame in found] == [0.9, 0.902, 0.91]
    assert found.color_is_apart and found.color_apart(1).shape == (2 * CAMERA.height, 2 * CAMERA.width, 3)


def test_colours_in_the_depth_camera_s_pixels_lie_over_depth(tmp_path):
    exported(tmp_path)
    (tmp_path / "intrinsic/intrinsic_color.txt").write_text((tmp_path / "intrinsic/intrinsic_depth.txt").read_text())
    found = open_recording(tmp_path)
    assert found.camera.color is None and found[0].color.shape[:2] == CAMERA.shape


def test_poses_of_lost_frames_are_missing(tmp_path):
    exported(tmp_path)
    (tmp_path / "pose/2.txt").write_text("-inf -inf -inf -inf\n" * 4)
    (tmp_path / "pose/10.txt").unlink()
    assert open_recording(tmp_path).poses.valid.tolist() == [True, False, False]


def test_a_camera_is_asked_for_where_none_lies_there(tmp_path):
    exported(tmp_path)
    (tmp_path / "intrinsic/intrinsic_depth.txt").unlink()
    with pytest.raises(RecordingError, match=r"no camera.*--camera"):
        open_recording(tmp_path)
    assert len(open_recording(tmp_path, "144,144,79.5,59.5")) == len(FRAMES)


@pytest.mark.parametrize(
    ("file", "text", "told"),
    [
        ("intrinsic/intrinsic_depth.txt", "1 2 3\n4 5 6\n", "camera cannot be used.*intrinsic_depth.txt"),
        ("intrinsic/intrinsic_depth.txt", "", "camera cannot be used"),
        ("intrinsic/intrinsic_color.txt", "a b\n", "intrinsic_color.txt"),
        ("pose/2.txt", "1 0 0 0\n", "no.* rigid matrix.*2.txt"),
        ("pose/2.txt", "2 0 0 0\n0 2 0 0\n0 0 2 0\n0 0 0 1\n", "no.* rigid matrix"),
    ],
)
def test_what_cannot_be_used_is_named(tmp_path, file, text, told):
    exported(tmp_path)
    (tmp_path / file).write_text(text)
    with pytest.raises(RecordingError, match=told) as caught:
        open_recording(tmp_path)
    assert "\n" not in str(caught.value)
