"""The judge of vertices' standard deviations: right ones are found right, wrong ones wrong."""

import numpy as np
import pytest
import trimesh

from fusion.mesh.files import write_mesh
from fusion.mesh.mesh import Mesh
from tools.sets.judging.coverage import coverage
from tools.sets.sigma_coverage import Judged, summary

TRUE_M = 5e-4


def scanned(folder, claimed):
    """A box with normal errors of half a millimetre, moved, whose vertices claim something; and the true one."""
    box = trimesh.creation.box((0.1, 0.12, 0.2)).subdivide_loop(0)
    for _ in range(5):
        box = box.subdivide()
    box.export(folder / "true.ply")
    normals = np.asarray(box.vertex_normals)
    error = TRUE_M * np.random.default_rng(3).standard_normal(len(normals))
    points = np.asarray(box.vertices) + error[:, None] * normals + [0.0005, 0, -0.0003]
    sigma = np.full(len(points), claimed, np.float32)
    write_mesh(folder / "scan.ply", Mesh(points, np.asarray(box.faces, np.int32), scalars={"sigma": sigma}))
    return coverage(folder / "scan.ply", folder / "true.ply", np.eye(4))


def test_a_right_sigma_is_found_right(tmp_path):
    found = scanned(tmp_path, TRUE_M)
    # the nearest point is a little nearer than the one along the normal, at edges
    assert found.ninety == pytest.approx(0.90, abs=0.02)
    assert found.one == pytest.approx(0.68, abs=0.03)
    assert found.rms == pytest.approx(TRUE_M, rel=0.05)


@pytest.mark.parametrize(("factor", "low", "high"), [(0.5, 0.5, 0.65), (2.0, 0.99, 1.0)])
def test_a_wrong_sigma_is_found_wrong(tmp_path, factor, low, high):
    assert low < scanned(tmp_path, factor * TRUE_M).ninety <= high


def test_scans_without_a_mesh_are_counted_apart(tmp_path):
    found = scanned(tmp_path, TRUE_M)
    nothing = type(found)()
    told = summary([Judged("a", "hard", "good", found, 0.02, 9.0), Judged("b", "hard", "failed", nothing, np.nan, 1.0)])
    assert "all        1 scans: 89." in told
    assert "no mesh handed out: 1" in told
    assert "sigma took 2.0%" in told
