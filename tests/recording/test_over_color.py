"""Depth brought before the colour camera: as that camera would have measured it, and nothing that it cannot see."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
import rendered

from fusion import open_recording
from fusion.geometry.camera import Camera
from fusion.geometry.pose import inverse
from fusion.geometry.trajectory import Trajectory
from fusion.recording.cameras.over_color import depth_over, fine_as
from fusion.recording.native.camera_file import write_camera
from fusion.recording.recording import Frame
from fusion.recording.writing.nerfstudio import fill_nerfstudio
from fusion.recording.writing.write import write_recording

DEPTH = Camera(320, 240, 290.0, 291.0, 158.0, 122.0, depth_scale=10000)
COLOR = Camera(480, 320, 430.0, 432.0, 241.0, 157.0)
FLIP = np.diag([1.0, -1, -1, 1])  # the scene's cameras have ARKit's axes
T_COLOR_DEPTH = np.eye(4)
T_COLOR_DEPTH[:3, 3] = [-0.032, 0.004, 0.002]


def seen(camera, T):
    return rendered.depth(T, camera.width, camera.height, camera.fx, camera.fy, camera.cx + 0.5, camera.cy + 0.5)


def scene(i=0):
    """Depth, and what the colour camera beside it would have measured, with its faces, at its coarser pixels."""
    T = rendered.cameras()[i]
    beside, coarse = T @ FLIP @ inverse(T_COLOR_DEPTH) @ FLIP, fine_as(COLOR, DEPTH)
    z = seen(DEPTH, T)[0]
    return np.where(z > 0, z, np.nan).astype(np.float32), *seen(coarse, beside), coarse


def test_it_is_what_the_other_camera_would_have_measured():
    depth, truth, face, coarse = scene()
    assert coarse.fx <= DEPTH.fx and coarse.shape == (216, 323)
    found = depth_over(depth, DEPTH, coarse, T_COLOR_DEPTH)
    there = np.isfinite(found)
    assert there.mean() > 0.75 and (truth[there] > 0).all()
    off = np.abs(found - truth)[there]
    # 0.2 px are 0.7 mm where the wall leans most; a few pixels at rims see the other side
    assert np.quantile(off, 0.98) < 0.2e-3 and np.mean(off > 2e-3) < 0.01
    assert len(np.unique(face[there])) >= 4


def test_colour_of_a_camera_beside_goes_to_splats(tmp_path):
    camera = replace(DEPTH, color=COLOR, T_color_depth=T_COLOR_DEPTH)
    picture = np.full((*COLOR.shape, 3), (200, 90, 40), np.uint8)
    frames = [Frame(i, i / 30, scene(i)[0]) for i in range(3)]
    poses = Trajectory(np.arange(3) / 30, rendered.cameras() @ FLIP)
    write_recording(tmp_path / "rec", DEPTH, frames, poses)
    (tmp_path / "rec" / "rgb").mkdir()
    lines = []
    for i in range(3):
        cv2.imwrite(str(tmp_path / "rec" / "rgb" / f"{i}.png"), picture[..., ::-1])
        lines.append(f"{i / 30:.6f} rgb/{i}.png")
    (tmp_path / "rec" / "rgb.txt").write_text("\n".join(lines) + "\n")
    write_camera(tmp_path / "rec" / "camera.json", camera)
    notes = []
    (tmp_path / "out").mkdir()
    fill_nerfstudio(tmp_path / "out", open_recording(tmp_path / "rec"), notes)
    assert any("colour camera" in note for note in notes)
    assert json.loads((tmp_path / "out" / "transforms.json").read_text())["w"] == 480
    again = open_recording(tmp_path / "out")
    expected = rendered.cameras() @ FLIP @ inverse(T_COLOR_DEPTH)
    np.testing.assert_allclose(again.poses.poses, expected, atol=1e-6)
    for i, frame in enumerate(again):
        off = np.abs(frame.depth - scene(i)[1])
        assert np.nanquantile(off, 0.98) < 0.25e-3 and again.camera.color.fx == pytest.approx(430)
