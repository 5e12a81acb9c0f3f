"""The judge of merges shares no code with the package, and knows the true transform."""

import ast
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from tools.sets.judging.writing import trajectory
from tools.sets.two_passes.cases import CASES, REFUSED, made
from tools.sets.two_passes.judged import true_transform
from tools.sets.two_passes.making import _turned_over

SETS = Path(__file__).resolve().parents[2] / "tools" / "sets"


def test_it_imports_nothing_of_the_package():
    for file in [*(SETS / "two_passes").glob("*.py"), SETS / "passes.py"]:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [str(node.module)] if isinstance(node, ast.ImportFrom) else []
            assert not [name for name in names if name.split(".")[0] == "fusion"], file


def test_six_objects_before_three_cameras():
    assert len({(case.shape, case.camera) for case in CASES}) == 18
    assert {case.refused for case in REFUSED} == {"different", "symmetric", "overlap"}


@pytest.mark.parametrize("name", ["lumpy", "mug", "box"])
def test_objects_stand_and_are_turned_over_by_80_degrees_or_more(name):
    rng = np.random.default_rng(5)
    item = made(name, rng, 0.2)
    assert abs(item.bounds[0, 2]) < 1e-9
    for _ in range(10):
        T = _turned_over(rng, item)
        np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-9)
        # one that comes to lie on a face is turned on by up to 45 deg to it
        assert np.degrees(np.arccos(np.clip(T[2, 2], -1, 1))) > 80 - 46


def test_the_true_transform_is_that_of_the_poses(tmp_path):
    rng = np.random.default_rng(2)
    poses = np.tile(np.eye(4), (2, 5, 1, 1))
    poses[..., :3, :3] = Rotation.random(10, random_state=3).as_matrix().reshape(2, 5, 3, 3)
    poses[..., :3, 3] = rng.standard_normal((2, 5, 3))
    scans = np.tile(np.eye(4), (2, 1, 1))
    scans[:, :3, :3] = Rotation.random(2, random_state=4).as_matrix()
    scans[:, :3, 3] = rng.standard_normal((2, 3))
    (tmp_path / "truth").mkdir()
    trimesh.creation.box([0.1, 0.2, 0.3]).export(tmp_path / "truth" / "object.ply")
    for k in (1, 2):
        (tmp_path / f"scan_{k}").mkdir()
        trajectory(tmp_path / "truth" / f"poses_{k}.txt", np.arange(5.0), poses[k - 1])
        some = slice(1, None)  # a frame that the scan has left out
        trajectory(tmp_path / f"scan_{k}" / "trajectory.txt", np.arange(5.0)[some], (scans[k - 1] @ poses[k - 1])[some])
    np.testing.assert_allclose(true_transform(tmp_path), scans[0] @ np.linalg.inv(scans[1]), atol=1e-6)
