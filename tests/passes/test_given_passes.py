"""What is given as passes: results that are not whole, merges, files of transforms."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from fusion.commands.main import main
from fusion.errors import FusionError
from fusion.geometry.pose import exp
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.mesh import Mesh
from fusion.passes.from_result import is_result, pass_of_result
from fusion.passes.one_pass import Pass
from fusion.passes.pipeline import merge_passes
from fusion.passes.transforms_file import read_transforms

SETTINGS = {
    "recording": "rec", "sensor": "kinect-v1", "voxel_m": 0.001, "truncation_m": 0.004, "mask": None,
    "region": {"low": [0, 0, 0.5], "high": [0.1, 0.1, 0.7]}, "camera": {"fx": 500.0, "fy": 500.0, "cx": 3.0, "cy": 4.0},
}  # fmt: skip


class Held(tuple):
    """A recording of the depth images that it holds."""

    def __new__(cls, path, *depths):
        made = super().__new__(cls, [SimpleNamespace(depth=depth) for depth in depths])
        made.path = path
        return made


@pytest.fixture
def result(tmp_path):
    """A result of a scan whose recording is gone."""
    folder = tmp_path / "scan"
    folder.mkdir()
    (folder / "settings.json").write_text(json.dumps(SETTINGS))
    (folder / "turntable.json").write_text('{"depth_taken_out": {}}')
    (folder / "trajectory.txt").write_text("1 0 0 0 0 0 0 1\n")
    (folder / "mesh.ply").write_text("ply\n")
    return folder


def test_a_recording_that_is_gone_is_told(result):
    assert is_result(result)
    with pytest.raises(FusionError, match=r"the recording of a scan is not there.*found rec"):
        pass_of_result(result)


@pytest.mark.parametrize("name", ["trajectory.txt", "mesh.ply"])
def test_a_result_that_is_not_whole_is_told(result, name):
    (result / name).unlink()
    with pytest.raises(FusionError, match=rf"not whole.*found no {name}"):
        pass_of_result(result)


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"voxel_m": 0}, "voxel_m"),
        ({"voxel_m": "1"}, "voxel_m"),
        ({"region": 5}, "region"),
        ({"camera": {"fx": -1.0, "fy": 500.0, "cx": 3.0, "cy": 4.0}}, "fx"),
        ({"recording": None}, "recording"),
        ({"keep_plate": True}, "the plate is in the scan"),
    ],
)
def test_settings_that_cannot_be_used_are_told(result, changed, told):
    (result / "settings.json").write_text(json.dumps(SETTINGS | changed))
    with pytest.raises(FusionError, match=told):
        pass_of_result(result)


def test_a_merge_is_no_pass(result):
    (result / "merge.json").write_text("{}")
    with pytest.raises(FusionError, match="a merge is no pass"):
        pass_of_result(result)


def test_transforms_are_read_and_refused(tmp_path):
    file, T = tmp_path / "merge.json", exp([0.1, 0.2, 0.3, 1, 2, 3])
    file.write_text(json.dumps({"passes": [{"T_merged_pass": np.eye(4).tolist()}, {"T_merged_pass": T.tolist()}]}))
    np.testing.assert_allclose(read_transforms(file)[1], T)
    file.write_text(json.dumps({"passes": [{"T_merged_pass": (2 * np.eye(4)).tolist()}]}))
    with pytest.raises(FusionError, match="no rigid motion"):
        read_transforms(file)
    file.write_text(json.dumps({"passes": [{}]}))
    with pytest.raises(FusionError, match="T_merged_pass"):
        read_transforms(file)


def test_one_pass_alone_and_one_twice_are_refused(tmp_path, capsys):
    with pytest.raises(FusionError, match="two passes or more"):
        merge_passes(["one"])
    assert main(["merge", "one", "-o", str(tmp_path / "out")]) == 1
    assert "two passes or more" in capsys.readouterr().err
    assert main(["merge", "one", "one", "-o", str(tmp_path / "out")]) == 1
    assert "given twice" in capsys.readouterr().err
    sensors = ["--sensor", "kinect-v1"] * 3
    assert main(["merge", "one", "two", *sensors, "-o", str(tmp_path / "out")]) == 1
    assert "found 3 times; expected once or 2 times" in capsys.readouterr().err


def test_a_copy_is_no_second_pass(tmp_path):
    """A copy of a result, and another scan of the same recording, are told before any work."""

    def given(name, place, depth):
        ball = trimesh.creation.icosphere(2, 0.1)
        mesh = Mesh(np.array(ball.vertices), np.array(ball.faces, np.int32))
        course = Trajectory(np.zeros(0), np.zeros((0, 4, 4)))
        return Pass(name, Held(place, depth), [], course, mesh, 0.001, 0.004, 0.001, "", {})

    depths = np.random.default_rng(0).uniform(1, 2, (2, 30, 40)).astype(np.float32)
    first = given("one", tmp_path, depths[0])
    for second in (given("copy", tmp_path / "elsewhere", depths[0]), given("again", tmp_path, depths[1])):
        with pytest.raises(FusionError, match="given twice"):
            merge_passes([first, second])
