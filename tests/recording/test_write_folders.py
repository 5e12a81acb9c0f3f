"""TUM's and Open3D's folders: what comes back by this program, and by Open3D and evo themselves."""

from dataclasses import replace

import numpy as np
import open3d
import pytest
import synthetic
from evo.tools import file_interface

from fusion import convert_recording, open_recording, write_recording
from fusion.commands.main import main
from fusion.recording.native.trajectory_file import read_trajectory
from fusion.recording.streamed import ImageSource
from fusion.recording.writing.convert import fill_conversion
from fusion.recording.writing.folders import fill_open3d, fill_tum
from fusion.recording.writing.write import depth_counts

CAMERA = "130,130,79.5,59.5"


@pytest.fixture(params=[1000.0, 5000.0], ids=["millimetres", "fifths of them"])
def original(request, tmp_path):
    camera = replace(synthetic.CAMERA, depth_scale=request.param)
    write_recording(tmp_path / "r", camera, synthetic.frames(3, color=True), synthetic.trajectory(3))
    return open_recording(tmp_path / "r")


def converted(original, kind, *words):
    out = original.path.parent / kind
    assert main(["convert", str(original.path), str(out), "--format", kind, *words]) == 0
    return out


def alike(one, other):
    """Depth and colour bit for bit, stamps to 1 us, poses to 1e-6."""
    assert len(one) == len(other) and np.abs(one.timestamps - other.timestamps).max() < 1e-6
    for i, frame in enumerate(one):
        assert np.array_equal(one.depth_counts(i), other.depth_counts(i))
        assert np.array_equal(frame.color, other[i].color)
    places = [r.poses.at(r.timestamps).poses for r in (one, other)]
    assert np.abs(places[0] - places[1]).max() < 1e-6


def test_a_tum_folder_comes_back(original, caplog):
    out = converted(original, "tum")
    scale = original.camera.depth_scale
    back = open_recording(out, replace(original.camera, depth_scale=scale))
    assert back.format == "tum"
    alike(back, original)
    assert f"its focal lengths and centre are {CAMERA} px" in caplog.text
    assert ("1000 counts" in caplog.text) == (scale == 1000)
    assert len((out / "associations.txt").read_text().splitlines()) == 3
    assert len((out / "associations.txt").read_text().split()) == 12
    assert file_interface.read_tum_trajectory_file(str(out / "groundtruth.txt")).num_poses == 3


def test_an_open3d_folder_comes_back(original, caplog):
    out = converted(original, "open3d")
    back = open_recording(out)
    assert back.format == "open3d" and back.camera.depth_scale == original.camera.depth_scale
    alike(back, original)
    assert ("depth_scale=5000" in caplog.text) == (original.camera.depth_scale == 5000)
    lens = open3d.io.read_pinhole_camera_intrinsic(str(out / "intrinsic.json"))
    assert lens.width == 160 and np.allclose(lens.intrinsic_matrix, original.camera.matrix)
    course = open3d.io.read_pinhole_camera_trajectory(str(out / "trajectory.log"))
    places = np.linalg.inv([view.extrinsic for view in course.parameters])
    assert np.abs(places - original.poses.poses).max() < 1e-6


@pytest.mark.parametrize("kind", ["tum", "open3d"])
def test_what_a_folder_has_no_place_for_is_told(tmp_path, kind, caplog):
    log = {"timestamp": np.arange(2.0), "turntable_deg": np.arange(2.0)}
    write_recording(tmp_path / "r", synthetic.CAMERA, synthetic.frames(2, ir=True), telemetry=log, scene={"a": 1})
    out = tmp_path / kind
    assert main(["convert", str(tmp_path / "r"), str(out), "--format", kind]) == 0
    assert "left out: infrared, telemetry, the scene" in caplog.text
    assert not (out / "groundtruth.txt").exists() and not (out / "trajectory.log").exists()


def test_from_folder_to_folder(original, tmp_path):
    """Through each of them, and home."""
    first = open_recording(converted(original, "open3d"))
    out = tmp_path / "home"
    convert_recording(first, out)
    alike(open_recording(out), original)


def test_poses_of_another_file_are_written(original, tmp_path):
    path = tmp_path / "other.txt"
    path.write_text("# t\n100 1 2 3 0 0 0 1\n100.033333 1 2 4 0 0 0 1\n")
    out = converted(original, "tum", "--poses", str(path))
    assert np.allclose(read_trajectory(out / "groundtruth.txt").poses[:, :3, 3], [[1, 2, 3], [1, 2, 4]])


@pytest.mark.parametrize("fill", [fill_conversion, fill_tum, fill_open3d])
def test_depth_that_is_no_counts_is_told_to_be_rounded(tmp_path, fill):
    frames = synthetic.frames(2)
    for number, scale in enumerate((1000.0, None)):
        depths = [f.depth if scale is None else depth_counts(f.depth, scale) / np.float32(scale) for f in frames]
        stamps = np.array([frame.timestamp for frame in frames])
        source = ImageSource(tmp_path, synthetic.CAMERA, stamps, depths.__getitem__)
        (tmp_path / str(number)).mkdir()
        notes: list[str] = []
        fill(tmp_path / str(number), source.recording("made", None, []), notes)
        assert any("rounded to whole counts of 1 mm" in note for note in notes) == (scale is None)
