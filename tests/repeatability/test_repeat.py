"""Scans whose spread, forms and conditions are known: what is said of them is right, and none is the reference."""

import json
from functools import cache

import numpy as np
import pytest
import trimesh

from fusion.commands.main import main
from fusion.errors import MeshError
from fusion.geometry import pose
from fusion.mesh.comparison.distances import surface_of
from fusion.mesh.files import read_mesh, write_mesh
from fusion.mesh.mesh import Mesh
from fusion.repeatability.bias import bias_and_spread
from fusion.repeatability.find_forms import find_forms
from fusion.repeatability.forms import Plane, Sphere, fit_plane, fit_sphere, form_error
from fusion.repeatability.numbers import repeatability, reproducibility
from fusion.repeatability.repeat import RepeatSettings, repeat
from fusion.repeatability.scans import read_scans
from fusion.repeatability.together import Together, lay_together
from fusion.results.repeat import judge_repeat

SPREAD, RADIUS, APART = 3e-4, 0.02, 0.09
ONE = np.zeros(5, np.intp)


@cache
def artefact():
    """Two balls on a block, as calibrated artefacts are, and smooth errors that a scan may have at its vertices."""
    block = trimesh.creation.box((0.14, 0.06, 0.03)).subdivide_to_size(0.006)
    balls = [trimesh.creation.icosphere(3, RADIUS).apply_translation((x, 0, 0.05)) for x in (-APART / 2, APART / 2)]
    whole = trimesh.util.concatenate([block, *balls])
    return np.array(whole.vertices), np.array(whole.faces, np.int32), np.array(whole.vertex_normals)


def scan(seed, spread=SPREAD, moved=True):
    """Errors along the normal that are smooth over 2 cm, of unit variance times the spread; in a pose of its own."""
    rng = np.random.default_rng(seed)
    vertices, faces, normals = artefact()
    waves = rng.standard_normal((60, 3)) / 0.02
    error = np.sqrt(2 / 60) * np.cos(vertices @ waves.T + rng.uniform(0, 2 * np.pi, 60)).sum(axis=1)
    T = pose.exp(np.r_[0.3 * rng.standard_normal(3), 0.05 * rng.standard_normal(3)]) if moved else np.eye(4)
    return Mesh(pose.transform(T, vertices + spread * error[:, None] * normals), faces)


@pytest.fixture(scope="module")
def found():
    return repeat([scan(k) for k in range(5)], RepeatSettings(diameter=2 * RADIUS, spacing=APART))


@pytest.mark.slow
def test_the_spread_is_the_true_one(found):
    # five scans of a surface of some hundred independent places; the poses take a little
    assert found.repeatability.s == pytest.approx(SPREAD, rel=0.1)
    assert found.repeatability.shown_by_all > 0.98
    assert set(found.together.status) <= {"kept", "moved"}


@pytest.mark.slow
def test_forms_are_found_and_measured(found):
    by_term = {}
    for quantity in found.features.quantities:
        by_term.setdefault(quantity.term, []).append(quantity)
    assert [q.mean for q in by_term["diameter"]] == pytest.approx([2 * RADIUS] * 2, abs=SPREAD)
    assert [q.mean for q in by_term["sphere spacing"]] == pytest.approx([APART], abs=SPREAD)
    assert abs(by_term["sphere spacing"][0].error) < SPREAD
    assert by_term["sphere spacing"][0].std < 2 * SPREAD
    assert len(by_term["flatness"]) >= 3
    # the band of 99.7 % of a normal error is six of its standard deviations; waves reach less, small planes too
    assert all(SPREAD < q.mean < 6 * SPREAD for q in by_term["flatness"])


@pytest.mark.slow
def test_no_scan_is_the_reference():
    """In another order the scans lie on each other as before."""
    meshes = [scan(k) for k in range(3)]
    forth, back = lay_together(meshes).poses, lay_together(meshes[::-1]).poses[::-1]
    between = [pose.inverse(T[0]) @ T[k] for T in (forth, back) for k in (1, 2)]
    for one, other in zip(between[:2], between[2:], strict=True):
        assert np.abs(one - other).max() < 0.1 * SPREAD / 0.07


def test_conditions_are_told_apart():
    """Five and five scans; the second five all carry one error more."""
    rng = np.random.default_rng(0)
    places, within, between = 20_000, 1e-4, 3e-4
    offsets = within * rng.standard_normal((places, 10))
    offsets[:, 5:] += between * np.sqrt(2) * rng.standard_normal((places, 1))
    condition = np.repeat([0, 1], 5)
    assert repeatability(offsets, condition).s == pytest.approx(within, rel=0.02)
    across = reproducibility(offsets, condition)
    # the variance between two conditions of which one carries the error is half of its
    assert across.between == pytest.approx(between, rel=0.03)
    assert across.s == pytest.approx(np.hypot(within, between), rel=0.03)
    assert reproducibility(offsets, np.zeros(10, np.intp)) is None


def test_missing_parts_count_where_they_are_shown():
    offsets = 1e-4 * np.random.default_rng(1).standard_normal((20_000, 5))
    offsets[:5000, 0] = np.nan
    said = repeatability(offsets, ONE)
    assert said.s == pytest.approx(1e-4, rel=0.02)
    assert said.shown_by_all == 0.75


def test_forms_fit_what_they_are_laid_through():
    rng = np.random.default_rng(2)
    out = rng.standard_normal((500, 3))
    ball = [0.1, 0.2, 0.3] + 0.02 * out / np.linalg.norm(out, axis=1, keepdims=True)
    sphere = fit_sphere(ball[ball[:, 2] > 0.3])
    assert sphere.centre == pytest.approx([0.1, 0.2, 0.3], abs=1e-9)
    assert sphere.radius == pytest.approx(0.02, abs=1e-9)
    flat = np.column_stack([rng.random((1000, 2)), 0.5 + 1e-3 * rng.random(1000)])
    plane = fit_plane(flat, np.array([0, 0, -1.0]))
    assert plane.normal == pytest.approx([0, 0, -1], abs=1e-3)
    assert form_error(plane, flat) == pytest.approx(1e-3, rel=0.05)


def test_a_rod_is_no_ball():
    """A ring of it fits a ball of its own radius within the noise: a ball bar's rod was measured as a third sphere."""
    rod = trimesh.creation.cylinder(0.006, 0.1, sections=96)
    balls = [trimesh.creation.icosphere(4, 0.019).apply_translation([0, 0, z]) for z in (-0.065, 0.065)]
    bar = trimesh.util.concatenate([rod, *balls])
    points, face = trimesh.sample.sample_surface(bar, 12000, seed=0)
    rng = np.random.default_rng(0)
    found = find_forms(points + 1e-4 * rng.standard_normal(points.shape), bar.face_normals[face], 4e-4)
    radii = [one.form.radius for one in found if isinstance(one.form, Sphere)]
    assert radii == pytest.approx([0.019, 0.019], rel=0.01)


def test_a_box_has_six_planes_and_no_ball():
    box = trimesh.creation.box((0.1, 0.12, 0.15))
    points, face = trimesh.sample.sample_surface(box, 8000, seed=0)
    found = find_forms(np.asarray(points), box.face_normals[face], 5e-4)
    assert sorted(type(one.form).__name__ for one in found) == ["Plane"] * 6
    assert not any(isinstance(one.form, Sphere) for one in found)
    assert all(isinstance(one.form, Plane) for one in found)


@pytest.mark.slow
def test_bias_and_spread_are_told_apart(found):
    apart = bias_and_spread(float(np.hypot(1e-3, found.repeatability.s / np.sqrt(5))), found)
    assert apart.bias == pytest.approx(1e-3)
    assert apart.spread == found.repeatability.s


@pytest.mark.parametrize("sizes", [(1, 1), (3,), (0, 2), (-1, 3)])
def test_conditions_that_do_not_add_up_are_refused(sizes):
    if sum(sizes) == 2 and min(sizes) > 0:
        return
    with pytest.raises(MeshError, match="conditions do not add up"):
        repeat([scan(0), scan(1)], RepeatSettings(conditions=sizes))


@pytest.mark.slow
def test_the_command_writes_its_files(tmp_path, capsys):
    for k in range(2):
        (tmp_path / f"scan_{k}").mkdir()
        write_mesh(tmp_path / f"scan_{k}" / "mesh.ply", scan(k))
    scans = [str(tmp_path / f"scan_{k}") for k in range(2)]
    assert main(["repeat", *scans, "-o", str(tmp_path / "out"), "--json", "--quiet"]) == 0
    said = json.loads(capsys.readouterr().out)
    content = json.loads((tmp_path / "out" / "repeat.json").read_text(encoding="utf-8"))
    assert content["repeatability"] == said["repeatability"]
    assert [row["name"] for row in content["scans"]] == ["scan_0", "scan_1"]
    assert "spread" in read_mesh(tmp_path / "out" / "spread.ply").scalars
    assert "sphere spacing" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_one_scan_is_refused(tmp_path, capsys):
    write_mesh(tmp_path / "one.ply", scan(0))
    assert main(["repeat", str(tmp_path / "one.ply"), "-o", str(tmp_path / "out")]) == 1
    assert "too few scans" in capsys.readouterr().err
    (tmp_path / "empty").mkdir()
    assert main(["repeat", str(tmp_path / "empty"), str(tmp_path / "one.ply"), "-o", str(tmp_path / "other")]) == 1
    assert "without mesh.ply" in capsys.readouterr().err


def test_a_copy_is_no_second_scan(tmp_path, capsys):
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        write_mesh(tmp_path / name / "mesh.ply", scan(0))
    assert main(["repeat", str(tmp_path / "one"), str(tmp_path / "two"), "-o", str(tmp_path / "out")]) == 1
    assert "a scan is given twice; in two; found each vertex where one has it" in capsys.readouterr().err
    with pytest.raises(MeshError, match="given twice; in scan 3"):
        repeat([scan(0), scan(1), scan(0)])


def test_scans_are_in_metres(tmp_path, capsys):
    """STL is millimetres as everywhere; another unit is told in one line before any work."""
    one = scan(0)
    in_mm = Mesh(1000 * scan(1).vertices, one.faces)
    for name, mesh in {"one.ply": one, "mm.ply": in_mm, "mm.stl": in_mm}.items():
        write_mesh(tmp_path / name, mesh)
    given = ["repeat", *(str(tmp_path / name) for name in ("one.ply", "mm.ply")), "-o", str(tmp_path / "out")]
    assert main(given) == 1
    assert "scans of other sizes; in mm.ply" in capsys.readouterr().err
    with pytest.raises(MeshError, match="other sizes"):  # all of them in millimetres
        repeat([in_mm, Mesh(1000 * one.vertices, one.faces)])
    (read,) = read_scans([tmp_path / "mm.stl"])
    assert np.ptp(read.mesh.vertices) == pytest.approx(np.ptp(scan(1).vertices), rel=1e-6)


def test_of_another_object_nothing_is_measured(monkeypatch, tmp_path, capsys):
    def lost(meshes):
        return Together(np.array([np.eye(4)] * 2), [surface_of(mesh) for mesh in meshes], ["kept", "poor"])

    monkeypatch.setattr("fusion.repeatability.repeat.lay_together", lost)
    found = repeat([scan(0, moved=False), scan(1, moved=False)])
    assert not found.features.quantities
    lights = judge_repeat(found).lights
    assert [light.subject for light in lights] == ["One object"] and judge_repeat(found).worth.word == "failed"
    for k in range(3):
        write_mesh(tmp_path / f"{k}.ply", scan(k, moved=False))
    assert main(["compare", *(str(tmp_path / f"{k}.ply") for k in range(3)), "-o", str(tmp_path / "out")]) == 1
    apart = ["repeat", *(str(tmp_path / f"{k}.ply") for k in range(2)), "-o", str(tmp_path / "apart")]
    assert main(apart) == 1 and not (tmp_path / "apart").exists()
    assert main([*apart, "--keep-failed"]) == 1
    assert (tmp_path / "apart/repeat.json").exists()
    assert "the scans have no mean" in (told := capsys.readouterr().err) and "found 1.ply: no pose" in told


def test_a_wide_band_finds_no_forms():
    """Within a tenth of its size an egg is a ball and its flanks are planes; within a hundredth they are not."""
    egg = trimesh.creation.icosphere(4, 0.1).apply_transform(np.diag([1.0, 0.8, 1.3, 1.0]))
    points, face = trimesh.sample.sample_surface(egg, 8000, seed=0)
    for width in (0.001, 0.02):
        assert not find_forms(np.asarray(points), egg.face_normals[face], width)


@pytest.mark.slow
def test_compare_of_several_scans_tells_bias_and_spread(tmp_path, capsys):
    true = scan(0, spread=0.0, moved=False)
    write_mesh(tmp_path / "true.ply", true)
    files = []
    for k in range(3):
        write_mesh(tmp_path / f"{k}.ply", scan(k))
        files.append(str(tmp_path / f"{k}.ply"))
    given = [*files, str(tmp_path / "true.ply"), "-o", str(tmp_path / "out"), "--no-report", "--quiet"]
    assert main(["compare", *given]) == 0
    said = capsys.readouterr().out
    assert "bias, spread" in said and "Scans alike" not in said
    content = json.loads((tmp_path / "out" / "comparison.json").read_text(encoding="utf-8"))
    # three scans tell a spread to a fifth and less, by the many places; of a bias there is none
    assert content["repeat"]["spread_m"] == pytest.approx(SPREAD, rel=0.2)
    assert content["repeat"]["bias_rms_m"] < 0.5 * SPREAD
    assert main(["compare", *given, "--no-align", "--overwrite"]) == 1
    assert "--no-align is for one mesh" in capsys.readouterr().err


@pytest.mark.slow
def test_compare_names_the_scan_that_is_off(tmp_path, capsys, monkeypatch):
    """Of four, one with four times the errors of the others, the mean was good and nothing else was said."""

    def lay(meshes):  # they stand where they lie on each other
        return Together(np.array([np.eye(4)] * len(meshes)), [surface_of(m) for m in meshes], ["kept"] * len(meshes))

    monkeypatch.setattr("fusion.repeatability.repeat.lay_together", lay)
    files = [str(tmp_path / f"{k}.ply") for k in range(4)]
    for k, name in enumerate(files):
        write_mesh(tmp_path / name, scan(k, (4 if k == 3 else 1) * SPREAD, moved=False))
    write_mesh(tmp_path / "true.ply", scan(0, spread=0.0, moved=False))
    assert main(["compare", *files, str(tmp_path / "true.ply"), "-o", str(tmp_path / "out"), "--quiet"]) == 0
    assert "Scans alike: scan 4 of 4, 3.ply: " in capsys.readouterr().out
    assert "scan 4 of 4, 3.ply" in (tmp_path / "out/report.html").read_text(encoding="utf-8")
