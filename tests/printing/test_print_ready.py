"""What comes out is closed and stands; what was seen stays; what was closed, moved and found wrong is told."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

import fusion
from fusion.commands.main import main
from fusion.errors import MeshError
from fusion.mesh.comparison.distances import signed_distances
from fusion.mesh.mesh import Mesh
from fusion.mesh.vertices import vertices_kept
from fusion.printing.closing import CLOSED, close_holes
from fusion.printing.faults import faults_of, is_solid
from fusion.printing.fewer import decimated, moved_by, smoothed
from fusion.printing.ready import PrintSettings, print_ready
from fusion.printing.touching import without_touching

BOX = (0.06, 0.05, 0.08)


def mesh_of(form):
    normals = np.asarray(form.vertex_normals, np.float32)
    return Mesh(np.array(form.vertices), np.array(form.faces, np.int32), normals)


def box(size=BOX):
    """A box that stands on z = 0, with vertices every 2 mm and its edges a little round, as scans have them."""
    form = trimesh.creation.box(size).apply_translation((0, 0, size[2] / 2)).subdivide_to_size(0.002)
    form.merge_vertices()
    return mesh_of(form)


def scanned():
    """The box as a turntable scan has it: from 4 mm above the plate, with a hole in its side, and sigma."""
    whole = box()
    whole = replace(whole, scalars={"sigma": np.full(len(whole.vertices), 2e-4, np.float32)})
    hole = np.linalg.norm(whole.vertices - [BOX[0] / 2, 0, 0.05], axis=1) < 0.008
    return vertices_kept(whole, (whole.vertices[:, 2] > 0.004) & ~hole)


@pytest.fixture(scope="module")
def closed():
    return close_holes(scanned())


def test_it_is_closed_and_a_solid(closed):
    made = closed.mesh.to_trimesh()
    assert made.is_watertight and made.is_winding_consistent
    # the whole box; the foot is closed at the plate. Its edges are round by a triangle
    assert made.volume == pytest.approx(np.prod(BOX), rel=0.01)
    assert made.bounds[0][2] == 0


def test_what_was_seen_stays(closed):
    seen = closed.mesh.scalars[CLOSED] == 0
    away = np.abs(signed_distances(closed.mesh.vertices[seen], scanned()))
    assert away.max() < 1e-6  # single precision of what finds the closest points
    # and nothing of it is lost: all of the scan, but for its borders, is near to what stays
    back = np.abs(signed_distances(scanned().vertices, closed.mesh))
    assert np.percentile(back, 95) < 2e-4
    assert closed.mesh.scalars["sigma"][seen] == pytest.approx(2e-4)


def test_what_was_closed_is_marked_and_counted(closed):
    missing = BOX[0] * BOX[1] + 2 * (BOX[0] + BOX[1]) * 0.004 + np.pi * 0.008**2
    assert closed.closed_area == pytest.approx(missing, rel=0.15)  # a triangle or two along its border
    gone = closed.mesh.scalars[CLOSED] == 1
    assert np.isnan(closed.mesh.scalars["sigma"][gone]).all()
    # it lies where the true box does: twice the seen part's error is asked of scans, here half a triangle
    assert np.sqrt(np.mean(signed_distances(closed.mesh.vertices[gone], box()) ** 2)) < 1e-3


def test_print_ready_says_what_it_did():
    made = print_ready(scanned(), PrintSettings(smooth=3, triangles=3000))
    assert len(made.mesh.faces) <= 3000
    assert made.mesh.to_trimesh().is_watertight
    assert made.mesh.vertices[:, 2].min() == 0
    assert 0 < made.decimated[0] < 5e-4 and 0 < made.smoothed[0] < 5e-4
    assert made.faults.crossing == 0 and made.faults.thin_share < 0.01
    told = "\n".join(made.lines())
    assert all(word in told for word in ("closed:", "smoothed:", "decimated:", "solid"))
    assert made.figures().faults.volume == pytest.approx(np.prod(BOX), rel=0.02)
    assert {"sigma", CLOSED} <= set(made.mesh.scalars)


def test_manifold3d_takes_it_for_a_solid(closed):
    pytest.importorskip("manifold3d", reason="the extra print is not installed")
    assert is_solid(closed.mesh) == (True, "a valid solid")
    assert is_solid(scanned())[0] is False
    inside_out = replace(closed.mesh, faces=closed.mesh.faces[:, ::-1])
    assert is_solid(inside_out)[0] is False


def test_without_manifold3d_it_is_said(closed, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "manifold3d", None)
    solid, why = is_solid(closed.mesh)
    assert solid is None and "fusion-scan[print]" in why


def test_decimation_states_its_error():
    ball = mesh_of(trimesh.creation.icosphere(5, 0.05))
    less = decimated(ball, 1000)
    rms, largest = moved_by(ball, less)
    # a ball of 1000 flat triangles: each stands back by its sagitta
    true = np.abs(signed_distances(less.vertices[less.faces].mean(axis=1), ball))
    assert len(less.faces) <= 1000
    assert largest >= true.max() > rms > 0
    assert decimated(ball, 10**6) is ball


def test_smoothing_takes_noise_out_and_keeps_the_size():
    ball = trimesh.creation.icosphere(4, 0.05)
    noise = 2e-4 * np.random.default_rng(0).standard_normal(len(ball.vertices))
    rough = Mesh(np.array(ball.vertices) * (1 + noise[:, None] / 0.05), np.array(ball.faces, np.int32))
    calm = np.linalg.norm(smoothed(rough, 10).vertices, axis=1) - 0.05
    assert calm.std() < 0.5 * noise.std()
    # a sixth of the noise, which makes a ball a little larger in its mean
    assert abs(calm.mean()) < 4e-5


@pytest.mark.parametrize(("thick", "thin"), [(0.0005, True), (0.003, False)])
def test_thin_walls_are_named(thick, thin):
    found = faults_of(box((0.05, 0.05, thick)))
    assert (found.thin_share > 0.8) is thin
    assert found.thinnest == pytest.approx(thick, rel=0.05) or not thin


def test_a_surface_through_itself_is_named():
    one, other = (
        trimesh.creation.icosphere(3, 0.03),
        trimesh.creation.icosphere(3, 0.03).apply_translation((0.02, 0, 0)),
    )
    assert faults_of(mesh_of(one)).crossing == 0
    assert faults_of(mesh_of(trimesh.util.concatenate([one, other]))).crossing > 20


def test_sheets_that_touch_are_parted():
    """Two tetrahedra that share an edge."""
    vertices = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 0], [0.5, 1, 0], [-1, 0, 0], [-0.5, -1, 0]], float)
    first, second = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], [[0, 4, 1], [0, 1, 5], [0, 5, 4], [1, 4, 5]]
    mesh = Mesh(vertices, np.array(first + second, np.int32), scalars={"a": np.arange(6, dtype=np.float32)})
    parted = without_touching(mesh)
    assert len(parted.vertices) == 8
    assert parted.to_trimesh().is_watertight
    assert sorted(parted.scalars["a"]) == [0, 0, 1, 1, 2, 3, 4, 5]
    assert without_touching(mesh_of(trimesh.creation.icosphere(2))).vertices.shape == (162, 3)


def test_convert_makes_it_printable(tmp_path, capsys):
    fusion.write_mesh(tmp_path / "scan.ply", scanned())
    given = ["convert", str(tmp_path / "scan.ply"), str(tmp_path / "out.stl"), "--watertight", "--triangles", "2000"]
    assert main(given) == 0
    told = capsys.readouterr().out
    assert "closed:" in told and "decimated:" in told
    made = trimesh.load(tmp_path / "out.stl")
    assert made.is_watertight
    assert made.extents == pytest.approx(1e3 * np.array(BOX), abs=1.0)  # millimetres
    assert made.bounds[0][2] == pytest.approx(0, abs=1e-3)


def test_what_cannot_be_printed_is_refused(tmp_path, capsys):
    fusion.write_mesh(tmp_path / "cloud.ply", Mesh(np.random.default_rng(0).random((50, 3))))
    assert main(["convert", str(tmp_path / "cloud.ply"), str(tmp_path / "out.ply"), "--watertight"]) == 1
    assert "a point cloud cannot be printed" in capsys.readouterr().err
    assert not (tmp_path / "out.ply").exists()
    assert main(["convert", str(tmp_path / "cloud.ply"), str(tmp_path / "out.ply"), "--thin", "0.001"]) == 1
    assert "--watertight" in capsys.readouterr().err
    with pytest.raises(MeshError, match="point cloud"):
        close_holes(Mesh(np.eye(3)))


def cone(low, hole=None):
    """The upper part of a cone that stands on a foot of 30 mm: open from `low` [m] down, perhaps with a hole in it."""
    form = trimesh.creation.revolve(np.array([[0.03, 0], [0.07, 0.08], [0.05, 0.15], [0, 0.16]]), sections=160)
    form = form.subdivide_to_size(0.003)
    keep = form.triangles_center[:, 2] > low
    if hole is not None:
        keep &= np.linalg.norm(form.triangles_center - hole, axis=1) > 0.006
    form.update_faces(keep)
    form.remove_unreferenced_vertices()
    return mesh_of(form)


@pytest.mark.parametrize("hole", [None, (0.0433, 0.0, 0.0266)], ids=["whole", "a hole in its flank"])
def test_below_an_overhang_the_flank_goes_on(hole):
    """Straight walls down from 9 mm would stand out by 4.5 mm; a hole in the flank has no foot of its own."""
    made = print_ready(cone(0.009, hole))
    foot = made.mesh.vertices[made.mesh.scalars["closed"] == 1]
    assert foot[:, 2].min() == pytest.approx(0, abs=1e-6)
    level = np.hypot(foot[:, 0], foot[:, 1])
    flank = 0.03 + foot[:, 2] / 2
    # Poisson rounds the edge of the foot by about one cell, 2 mm
    assert (level - flank).max() < 0.002
    assert level.max() == pytest.approx(0.0345, abs=0.002) or hole is not None
    low = made.mesh.vertices[:, 2] < 0.001
    assert np.hypot(*made.mesh.vertices[low, :2].T).max() == pytest.approx(0.03, abs=0.002)
