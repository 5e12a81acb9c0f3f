"""A mesh's own standard deviation stays with it, and deviations are told beside it."""

import json

import numpy as np
import pytest
import trimesh

import fusion
from fusion.commands.main import main
from fusion.mesh.cleanup import fill_small_holes, large_parts, without_crumbs
from fusion.mesh.comparison.compare import CompareSettings, compare
from fusion.mesh.comparison.statistics import OVER, SIGMA
from fusion.mesh.files import read_mesh, write_mesh
from fusion.mesh.mesh import Mesh
from fusion.results.comparison import judge_comparison

RADIUS = 0.05


def ball(sigma=1e-3, off=0.0, seed=1, faces=None):
    """A ball whose vertices err by sigma, and by `off` beyond it."""
    form = trimesh.creation.icosphere(4, RADIUS)
    normals = np.array(form.vertices) / RADIUS
    error = sigma * np.random.default_rng(seed).standard_normal(len(normals)) + off
    known = {SIGMA: np.full(len(normals), sigma, np.float32)}
    faces = np.array(form.faces) if faces is None else np.array(form.faces)[faces]
    return Mesh(np.array(form.vertices) + error[:, None] * normals, faces, normals.astype(np.float32), scalars=known)


TRUE = ball(0.0)
AS_THEY_STAND = CompareSettings(align=False, samples=2000)


def test_errors_as_large_as_said_are_within_doubt():
    found = compare(ball(), TRUE, AS_THEY_STAND).knowable
    # 2562 normal errors: a standard error of 0.006
    assert found.within_90 == pytest.approx(0.9, abs=0.03)
    assert found.beyond_3_sigma < 0.01
    assert found.sigma_median == pytest.approx(1e-3)


def test_what_the_scan_cannot_explain_is_beyond():
    comparison = compare(ball(sigma=1e-4, off=2e-3), TRUE, AS_THEY_STAND)
    assert comparison.knowable.beyond_3_sigma > 0.99
    light = next(light for light in judge_comparison(comparison).lights if light.subject == "Beyond the scan's doubt")
    assert light.level == "bad"
    over = comparison.mesh.scalars[OVER]
    assert over == pytest.approx(comparison.mesh.scalars["signed_distance"] / 1e-4, rel=1e-4)


def test_a_mesh_without_sigma_says_nothing_of_it():
    bare = Mesh(TRUE.vertices, TRUE.faces)
    found = compare(bare, TRUE, AS_THEY_STAND)
    assert found.knowable is None
    assert OVER not in found.mesh.scalars
    assert found.to_dict()["sigma"] is None


def test_the_command_writes_it(tmp_path):
    write_mesh(tmp_path / "scan.ply", ball())
    write_mesh(tmp_path / "true.ply", Mesh(TRUE.vertices, TRUE.faces))
    told = [str(tmp_path / name) for name in ("scan.ply", "true.ply")]
    assert main(["compare", *told, "-o", str(tmp_path / "out"), "--no-align", "--no-report", "--quiet"]) == 0
    content = json.loads((tmp_path / "out" / "comparison.json").read_text(encoding="utf-8"))
    assert 0.8 < content["sigma"]["within_90"] < 1
    written = read_mesh(tmp_path / "out" / "distance.ply")
    assert {SIGMA, OVER, "signed_distance"} <= set(written.scalars)


def test_sigma_stays_through_file_and_clean_up(tmp_path):
    most = np.arange(5100)  # some faces are missing: a hole
    mesh = ball(faces=most)
    write_mesh(tmp_path / "scan.ply", mesh)
    again = fusion.read_mesh(tmp_path / "scan.ply")
    assert again.scalars[SIGMA] == pytest.approx(mesh.scalars[SIGMA])
    for cleaned in (large_parts(again, 0.05)[0], without_crumbs(again, 0.01), fill_small_holes(again, 0.2)):
        assert len(cleaned.scalars[SIGMA]) == len(cleaned.vertices)
        assert cleaned.scalars[SIGMA] == pytest.approx(1e-3)
