"""Fresh units: the generator's own optics and light, what it writes, and the judge's measures."""

import ast
import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh

from tools.sets.fresh import dots, flight, lens
from tools.sets.fresh.angles import angle_std
from tools.sets.fresh.information import depth_std, focal_std
from tools.sets.fresh.judged import Judged
from tools.sets.fresh.lens import Lens
from tools.sets.fresh.making import _scan, held
from tools.sets.fresh.table import line, row, summary
from tools.sets.fresh.unit import NOMINAL, drawn
from tools.sets.fresh.views import Plane
from tools.sets.judging.command import Ran
from tools.sets.judging.measured import angle_errors, offset, own_fit
from tools.sets.judging.said import Said, read
from tools.sets.planted.measure import Surface

SETS = Path(__file__).resolve().parents[2] / "tools" / "sets"
LENS = Lens(64, 48, 45.0, 45.2, 31.0, 24.5, (0.05, -0.06, 4e-4, -3e-4))
WALL = Plane(np.array([0.05, -0.02, -0.9985]) / np.linalg.norm([0.05, -0.02, -0.9985]), 0.9)


@pytest.mark.parametrize("package", ["judging", "fresh", "hard"])
def test_the_judges_use_nothing_of_the_package(package):
    for file in [*(SETS / package).rglob("*.py"), SETS / "fresh_units.py", SETS / "hard_scans.py"]:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not [n for n in names if n.split(".")[0] == "fusion"], f"{file.name} imports {names}"


def test_the_lens_is_opencvs():
    rays = LENS.rays(0.25, -0.25)
    K = np.array([[LENS.fx, 0, LENS.cx], [0, LENS.fy, LENS.cy], [0, 0, 1]])
    bend = np.array(LENS.fields["distortion"])
    seen = cv2.projectPoints(rays.reshape(-1, 3), np.zeros(3), np.zeros(3), K, bend)[0].reshape(48, 64, 2)
    v, u = np.mgrid[:48, :64]
    np.testing.assert_allclose(seen[..., 0], u + 0.25, atol=1e-4)
    np.testing.assert_allclose(seen[..., 1], v - 0.25, atol=1e-4)
    np.testing.assert_allclose(LENS.pixels(rays), seen, atol=1e-6)


def test_a_lens_that_folds_the_image_before_its_corners_does_not_cover_it():
    assert LENS.covers
    assert not replace(LENS, bend=(-0.2, -0.3, 0.0, 0.0)).covers
    assert all(lens.drawn(np.random.default_rng(seed), NOMINAL["itof"]).covers for seed in range(5))


@pytest.mark.parametrize("module", [flight, dots])
def test_depth_without_errors_is_that_of_the_wall_but_for_the_noise_stated(module):
    rng = np.random.default_rng(3)
    device, rays = module.drawn(rng, LENS), LENS.four()
    true = WALL.look(LENS.rays()).z
    depths, _ = device.frames(WALL, 20, rng, rays, ideal=True)
    inside = (slice(6, -6), slice(6, -12))  # the projector leaves a margin in shadow
    error = depths[(slice(None), *inside)] - true[inside]
    assert abs(np.median(error)) < 0.002
    if module is flight:
        expected = device.range_std(np.array([device.counts * 0.8 / 0.9**2]))[0]
        assert np.median(error.std(axis=0)) == pytest.approx(expected, rel=0.2)
    else:
        assert np.median(error.std(axis=(1, 2))) == pytest.approx(device.depth_std(np.array([0.9]))[0], rel=0.4)


@pytest.mark.parametrize("module", [flight, dots])
def test_a_unit_has_errors_that_grow_with_nothing_but_its_laws(module):
    rays, sizes = LENS.four(), []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        device = module.drawn(rng, LENS)
        with_laws, without = (device.frames(WALL, 1, np.random.default_rng(1), rays, ideal)[0] for ideal in (0, 1))
        both = (with_laws > 0) & (without > 0)
        sizes.append(float(np.median(np.abs(with_laws - without)[both])))
    assert 0.001 < np.median(sizes) < 0.02


def test_a_scan_shows_the_true_points_where_its_poses_say(tmp_path):
    rng = np.random.default_rng(5)
    unit = drawn("structured_light", "blocks", "unit", rng)
    few = type(unit.turning)(*(x[:2] if np.ndim(x) else x for x in vars(unit.turning).values()))
    few = type(few)(few.true, few.logged, unit.turning.point, unit.turning.direction, -1)
    unit = type(unit)(unit.name, unit.device, unit.shape, unit.table, few, unit.walls)
    (tmp_path / "truth").mkdir()
    stated = {"depth_scale": 5000}
    _scan(unit, tmp_path, stated, unit.device.lens.four(), 1)
    points = np.load(tmp_path / "truth" / "visible.npz")["points"]
    assert np.median(Surface(unit.table.item.mesh).distance(points[::40])) < 1e-4
    T = np.linalg.inv(unit.poses()[1])
    own = points[400:] @ T[:3, :3].T + T[:3, 3]  # of the second frame, in its camera
    u, v = np.rint(unit.device.lens.pixels(own)).astype(int).T
    files = sorted((tmp_path / "clean" / "depth").iterdir())
    depth = cv2.imread(str(files[1]), cv2.IMREAD_UNCHANGED) / 5000
    seen = depth[v, u] > 0
    assert seen.mean() > 0.8
    assert np.median(np.abs(depth[v, u] - own[:, 2])[seen]) < 0.002


def test_boards_are_wholly_in_the_picture():
    rng = np.random.default_rng(7)
    unit = drawn("itof", "blocks", "unit", rng)
    board = held(unit, rng)
    seen = unit.device.lens.pixels(board.corners)
    assert (seen > 3).all() and (seen < [252, 208]).all()
    grey = board.look(unit.device.lens.rays()).reflectance
    assert set(np.unique(grey)) == {0.0, 0.1, 0.85}


def test_more_walls_and_corners_tell_more():
    many, some = (depth_std(np.linspace(0.6, 1.7, n), 0.9, True) for n in (10, 6))
    assert many < some < 0.001
    rng = np.random.default_rng(2)
    unit = drawn("itof", "blocks", "unit", rng)
    corners = np.array([unit.device.lens.pixels(held(unit, rng).corners) for _ in range(6)])
    fields = unit.device.lens.fields
    assert focal_std(fields, corners, 0.02) < focal_std(fields, corners[:4], 0.02)
    assert focal_std(fields, corners, 0.04) == pytest.approx(2 * focal_std(fields, corners, 0.02))


def test_angles_are_told_better_by_better_pixels():
    unit = drawn("itof", "blocks", "unit", np.random.default_rng(2))
    turning = replace(unit.turning, true=unit.turning.true[:12], logged=unit.turning.logged[:12])
    lens = Lens(64, 53, 45.6, 45.6, 31.5, 26.0)
    unit = replace(unit, turning=turning, device=replace(unit.device, lens=lens))
    noisy = replace(unit.device, grain=4 * unit.device.grain, dark=4 * unit.device.dark)
    good = angle_std(unit)
    assert 0.01 < good < 0.5
    # what stands still in the image is no better known: the bound grows by less than the noise
    assert 1.5 * good < angle_std(replace(unit, device=noisy)) < 2.001 * good


def test_a_known_size_is_measured_and_angles_lose_one_constant(tmp_path):
    mesh = trimesh.creation.box([0.1, 0.14, 0.2])
    mesh.export(tmp_path / "true.ply")
    large = mesh.copy()
    large.apply_scale(1.01)
    large.apply_translation([0.002, -0.003, 0.001])
    large.export(tmp_path / "large.ply")
    found = own_fit(tmp_path / "large.ply", tmp_path / "true.ply", np.eye(4))
    assert found.scale == pytest.approx(1.01, abs=1e-4)
    assert 0.0001 < found.std < 0.001  # faces of 0.1 to 0.2 m, each 0.5 to 1 mm too far out
    thick = trimesh.creation.box([0.102, 0.142, 0.202])
    thick.export(tmp_path / "thick.ply")
    assert offset(tmp_path / "thick.ply", tmp_path / "true.ply") == pytest.approx(0.001, abs=1e-5)
    errors = angle_errors({"angles_rad": [0.0, None, 0.2, 0.31]}, np.array([0.5, 0.6, 0.7, 0.8]))
    np.testing.assert_allclose(errors, [0, np.nan, 0, np.rad2deg(0.01)], atol=1e-9)


def test_what_was_said_is_read(tmp_path):
    assert read(tmp_path, Ran(0, "", 1.0)).verdict == "good"  # nothing said is good by that
    refused = read(tmp_path, Ran(1, "working\nfusion turntable: nothing turns\n", 1.0))
    assert (refused.verdict, refused.words) == ("failed", ("fusion turntable: nothing turns",))
    (tmp_path / "turntable.json").write_text(json.dumps({"verdict": "doubtful", "reasons": ["the scale is loose"]}))
    said = read(tmp_path, Ran(0, "", 1.0))
    assert said.verdict == "doubtful" and said.stated and said.names(r"\bscale\b")


def one(scale, verdict="good", words=()):
    from tools.sets.fresh.information import Allowed

    said = Said(verdict, True, 0, tuple(words))
    return Judged("unit", "itof", "statue", said, Allowed(0.0005, 0.0003, 0.0004, 0.02), scale, scale, 0.1, 0.2)


def test_a_wrong_scale_has_to_be_said():
    units = [one(0.001), one(0.006), one(0.006, words=["the depth is off"]), one(float("nan"), "failed")]
    assert [u.within for u in units] == [True, False, False, False]
    assert [u.unsaid for u in units] == [False, True, False, False]
    assert not one(0.006, words=["Surface: black parts give no depth"]).told
    assert "1 of 4" in summary(units)
    assert [line(u).split()[5] for u in units] == ["yes", "no", "no", "no"]
    assert row(units[3])["scale"] is None
