"""`fusion convert` between kinds of mesh files: each as those who open it take its numbers."""

import numpy as np
import pytest
import trimesh

from fusion import read_mesh
from fusion.commands.main import main

CORNERS = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.3]])  # [m], z up
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


@pytest.fixture
def scan(tmp_path):
    trimesh.Trimesh(CORNERS, FACES, process=False).export(tmp_path / "scan.ply")
    return tmp_path / "scan.ply"


def size_of(path):
    return np.ptp(trimesh.load(path, force="mesh").vertices, axis=0)


@pytest.mark.parametrize("words, factor", [([], 1000), (["--unit", "m"], 1), (["--unit", "inch"], 1 / 0.0254)])
def test_stl_is_millimetres_unless_told(scan, capsys, words, factor):
    made = scan.with_name("part.stl")
    assert main(["convert", str(scan), str(made), *words]) == 0
    np.testing.assert_allclose(size_of(made), np.array([0.1, 0.2, 0.3]) * factor, rtol=1e-6)
    assert capsys.readouterr().out.splitlines()[-1] == str(made)
    assert main(["convert", str(made), str(scan.with_name("again.ply")), *words]) == 0
    assert "size: 0.1 x 0.2 x 0.3 m" in capsys.readouterr().out
    np.testing.assert_allclose(size_of(scan.with_name("again.ply")), [0.1, 0.2, 0.3], rtol=1e-6)


def test_glb_has_its_y_axis_up(scan):
    made, again = scan.with_name("part.glb"), scan.with_name("again.ply")
    assert main(["convert", str(scan), str(made)]) == 0
    seen = trimesh.load(made, force="mesh")
    np.testing.assert_allclose(seen.vertices, CORNERS[:, [0, 2, 1]] * [1, 1, -1], atol=1e-7)
    assert seen.volume == pytest.approx(0.1 * 0.2 * 0.3 / 6, rel=1e-5)  # not mirrored: its faces still look outwards
    assert main(["convert", str(made), str(again)]) == 0
    np.testing.assert_allclose(read_mesh(again).vertices, CORNERS, atol=1e-7)


def test_one_kind_stays_as_it_is(scan):
    trimesh.Trimesh(CORNERS, FACES).export(scan.with_name("a.stl"))
    assert main(["convert", str(scan.with_name("a.stl")), str(scan.with_name("b.stl"))]) == 0
    np.testing.assert_allclose(size_of(scan.with_name("b.stl")), [0.1, 0.2, 0.3], rtol=1e-6)


def test_a_unit_of_what_has_none_to_say_is_refused(scan, capsys):
    assert main(["convert", str(scan), str(scan.with_name("x.obj")), "--unit", "mm"]) == 1
    assert "--unit is for an STL file" in capsys.readouterr().err
    assert not scan.with_name("x.obj").exists()
