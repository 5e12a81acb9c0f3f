"""`fusion convert` between kinds of mesh files: each as those who open it take its numbers."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from fusion import Mesh, read_mesh, write_mesh
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


def ball_at(tmp_path, place):
    """A ball of 120 mm in double precision, its edges about 5 mm."""
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.06)
    mesh = Mesh(np.asarray(ball.vertices) + place, np.asarray(ball.faces, np.int32))
    write_mesh(tmp_path / "ball.ply", mesh)
    return tmp_path / "ball.ply", mesh


@pytest.mark.parametrize("ending", ["stl", "glb", "pcd", "3mf", "usdz"])
def test_32_bits_do_not_bend_what_lies_far_out(tmp_path, capsys, ending):
    """At coordinates of a survey float32 is spaced by 0.5 m, four times the ball; 100 m out it is 8 um."""
    pytest.importorskip({"3mf": "lib3mf", "usdz": "pxr"}.get(ending, "trimesh"))
    path, _ = ball_at(tmp_path, [4.5e5, 5.4e6, 300.0])
    made = path.with_suffix(f".{ending}")
    assert main(["convert", str(path), str(made)]) == 1
    told = capsys.readouterr().err
    assert f"{ending.upper()} holds coordinates in 32 bits" in told
    assert "write PLY or OBJ" in told and made.name in told
    assert not made.exists()
    path, _ = ball_at(tmp_path, 100.0)
    assert main(["convert", str(path), str(made)]) == 0


@pytest.mark.parametrize("ending", ["ply", "obj", "off", "xyz"])
def test_other_formats_keep_what_lies_far_out(tmp_path, ending):
    path, mesh = ball_at(tmp_path, [4.5e5, 5.4e6, 300.0])
    made = tmp_path / "out" / f"ball.{ending}"
    made.parent.mkdir()
    assert main(["convert", str(path), str(made)]) == 0
    # eight decimals of OBJ
    np.testing.assert_allclose(read_mesh(made).vertices, mesh.vertices, rtol=0, atol=2e-8)


def test_a_speck_far_out_is_no_reason_to_refuse(tmp_path):
    path, mesh = ball_at(tmp_path, 0.0)
    vertices = np.vstack([mesh.vertices, [1e6, 0.3, 0.1]])
    write_mesh(path, replace(mesh, vertices=vertices))
    assert main(["convert", str(path), str(tmp_path / "ball.stl")]) == 0
