"""Scans of which one shows something else, all, half or at one place: it is named, and what is the same is measured."""

import numpy as np
import pytest
import trimesh

from fusion.commands.main import main
from fusion.mesh.comparison.distances import surface_of
from fusion.mesh.files import write_mesh
from fusion.mesh.mesh import Mesh
from fusion.repeatability.find_forms import find_forms
from fusion.repeatability.repeat import RepeatSettings, repeat
from fusion.repeatability.together import Together
from fusion.results.repeat import judge_repeat

RADIUS, NOISE = 0.1, 1e-4


def lump(seed, noise=0.0, shape=0, scale=1.0, kept=None, bump=0.0, wide=0.01):
    """A lump of low waves, other ones for another shape; smooth errors over 2 cm, a triangulation of its own.

    `kept`: which directions (n, 3) it shows; `bump`: height [m] of a place about (1, 0, 0), 13 mm wide unless `wide`
    is larger.
    """
    rng = np.random.default_rng(seed)
    ball = trimesh.creation.icosphere(5)
    way = ball.vertices @ trimesh.transformations.random_rotation_matrix(rng.random(3))[:3, :3].T
    low, errors = np.random.default_rng(100 + shape), rng.standard_normal((60, 3)) * 15
    relief = np.cos(way @ low.standard_normal((8, 3)).T * 3 + low.uniform(0, 6, 8)).sum(axis=1)
    error = np.sqrt(2 / 60) * np.cos(way @ errors.T + rng.uniform(0, 2 * np.pi, 60)).sum(axis=1)
    away = scale * RADIUS * (1 + 0.02 * relief) + noise * error + bump * np.exp(-(1 - way[:, 0]) / wide)
    faces = ball.faces if kept is None else ball.faces[kept(way)[ball.faces].all(axis=1)]
    used, faces = np.unique(faces, return_inverse=True)
    return Mesh((way * away[:, None])[used], faces.reshape(-1, 3).astype(np.int32))


@pytest.fixture(autouse=True)
def placed(monkeypatch):
    """The scans stand where they lie on each other: alignment has tests of its own."""

    def lay(meshes):
        n = len(meshes)
        return Together(np.array([np.eye(4)] * n), [surface_of(mesh) for mesh in meshes], ["kept"] * n)

    monkeypatch.setattr("fusion.repeatability.repeat.lay_together", lay)


def light(found, subject="Scans alike"):
    return next(one for one in judge_repeat(found).lights if one.subject == subject)


def test_another_object_among_three_is_refused(tmp_path, capsys):
    """Two that are alike and another object: its distance was in the mean of all, and all lay alike about that."""
    for name, mesh in {"a": lump(0), "b": lump(1), "c": lump(2, shape=1)}.items():
        write_mesh(tmp_path / f"{name}.ply", mesh)
    given = ["repeat", *(str(tmp_path / f"{name}.ply") for name in "abc"), "-o", str(tmp_path / "out"), "--no-report"]
    assert main([*given, "--quiet"]) == 1
    told = capsys.readouterr()
    assert "scan 3 of 3, c.ply" in told.err and "off the others" in told.err
    assert not (tmp_path / "out").exists()
    assert main([*given, "--quiet", "--keep-failed"]) == 1
    assert (tmp_path / "out" / "repeat.json").exists()


def test_two_other_objects_of_five_hide_nothing():
    found = repeat([lump(k) for k in range(3)] + [lump(k, shape=1) for k in (3, 4)])
    assert [row.alignment for row in found.offsets()] == ["kept"] * 3 + ["poor"] * 2


def test_a_noisier_scan_is_named():
    found = repeat([lump(0, NOISE), lump(1, NOISE), lump(2, 10 * NOISE)])
    said = light(found)
    assert said.level == "bad" and not said.fails
    assert said.reason.startswith("scan 3 of 3, scan 3: ")
    # the difference of two scans of variances v and w has v + w
    assert found.others[2].off == pytest.approx(NOISE * np.sqrt(101), rel=0.1)
    assert found.others[2].apart == pytest.approx(NOISE * np.sqrt(2), rel=0.1)


@pytest.mark.parametrize("scales", [(1, 1, 1), (1, 1.0002, 1.003)])
def test_scans_that_err_alike_are_good(scales):
    """Two of three scales are nearly equal by chance now and then: one number of each scan tells no odd one out."""
    noise = NOISE if scales[1] == 1 else 0
    found = repeat([lump(k, noise, scale=scale) for k, scale in enumerate(scales)])
    assert light(found).level == "ok"


def test_of_two_scans_none_is_named():
    assert light(repeat([lump(0, NOISE), lump(1, NOISE)])).level == "ok"
    apart = light(repeat([lump(0), lump(1, shape=1)]))
    assert apart.level != "ok" and "none tells which" in apart.reason


def test_conditions_may_differ():
    settings = RepeatSettings(conditions=(3, 3))
    found = repeat([lump(k, NOISE, scale=1.003 if k > 2 else 1.0) for k in range(6)], settings)
    assert light(found).level == "ok"
    assert found.repeatability.s == pytest.approx(NOISE, rel=0.1)


def test_half_a_scan_beside_a_whole_one():
    """Where one scan alone makes the mean, it lies on it: that says nothing of how far scans lie from each other."""
    found = repeat([lump(0, NOISE), lump(1, NOISE, kept=lambda way: way[:, 2] < 0)])
    assert found.repeatability.s == pytest.approx(NOISE, rel=0.1)
    assert found.repeatability.shown_by_all == pytest.approx(0.5, abs=0.03)


def test_a_bump_is_a_difference_and_not_missing():
    high = 3e-3
    found = repeat([lump(0), lump(1, bump=high)])
    assert found.repeatability.shown_by_all > 0.999
    # over the ball the square of exp(-(1 - cos) / a) has a / 4 for its mean; two scans lie half of it off their mean
    assert found.repeatability.s == pytest.approx(high * np.sqrt(0.01 / 4) / np.sqrt(2), rel=0.1)
    assert found.place.height_m == pytest.approx(high, rel=0.1)
    assert np.linalg.norm(found.place.centre_m - found.place.centre_m[0] * np.array([1, 0, 0])) < 0.01
    assert light(found, "Same everywhere").level == "warning"


def test_a_place_is_told_as_wide_as_it_is():
    """Of a wide place little more than chance stood out: a place 2 mm across was told, and that all is the same."""
    high, noise = 3e-3, 3e-4
    scans = [lump(k, noise) for k in range(4)] + [lump(4, noise, bump=high, wide=0.1)]
    found = repeat(scans)
    assert found.place.scan == 4
    assert found.place.height_m == pytest.approx(high, rel=0.25)
    half = 0.1 * np.log(2) / 2  # of the ball, where it is half as high
    assert found.place.share == pytest.approx(half, rel=0.25)
    assert light(found, "Same everywhere").level == "warning"


def test_a_part_that_one_lacks_is_missing():
    """What is nearest to it is another part, which the mean has already."""
    ball = trimesh.creation.icosphere(4, 0.02).apply_translation((0.16, 0, 0))
    body = lump(0, NOISE)
    faces = np.vstack([body.faces, ball.faces + len(body.vertices)]).astype(np.int32)
    found = repeat([Mesh(np.vstack([body.vertices, ball.vertices]), faces), lump(1, NOISE)])
    lacks = found.offsets()[1].missing_share
    assert lacks == pytest.approx(ball.area / (ball.area + 4 * np.pi * RADIUS**2), rel=0.15)
    assert found.repeatability.s == pytest.approx(NOISE, rel=0.1)


@pytest.mark.parametrize("width", [5e-4, 1.8e-3, 4e-3])
def test_a_lump_has_no_forms(width):
    """A band cuts a patch out of any smooth surface: its points fill the band, and those of a form do not."""
    mesh = lump(0)
    solid = trimesh.Trimesh(mesh.vertices, mesh.faces)
    points, face = trimesh.sample.sample_surface(solid, 12000, seed=0)
    assert not find_forms(np.asarray(points), solid.face_normals[face], width)
