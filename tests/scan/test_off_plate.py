"""The plate is cut off as near as its noise allows, and the object stands on it: low, high, sloped, tilted."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest

from fusion.geometry import pose
from fusion.mesh.mesh import Mesh
from fusion.mesh.shape import shape_of
from fusion.scan.cleaning.clean import clean
from fusion.scan.cleaning.off_plate import fitted_plate
from fusion.scan.settings import ScanSettings

VOXEL = 0.001
SIZE = 0.1
UP = np.array([0.0, 0.0, 1.0])


def plate(tilt, bend, noise=0.0003, seed=0):
    """(n, 3) points of a plate of 30 cm, and its height at (n, 2) places."""

    def height(xy):
        return 0.002 + xy @ tilt + bend * (xy**2).sum(axis=1)

    rng = np.random.default_rng(seed)
    xy = rng.uniform(-0.15, 0.15, (20_000, 2))
    xy = xy[np.linalg.norm(xy, axis=1) < 0.15]
    return np.column_stack([xy, height(xy) + rng.normal(0, noise, len(xy))]), height


def block(top, height, half=0.05, n=60):
    """(n, 3) points and normals of a block whose level top is `top` above the plate's middle."""
    side = np.linspace(-half, half, n)
    x, y = (g.ravel() for g in np.meshgrid(side, side))
    points, normals = [np.column_stack([x, y, np.full(n * n, 0.002 + top)])], [np.tile([0, 0, 1.0], (n * n, 1))]
    for turn in range(4):
        R = pose.about_axis([0, 0, 0], [0, 0, 1], turn * np.pi / 2)[:3, :3]
        foot = np.column_stack([np.full(n * n, half), x, y])
        low = height((foot @ R.T)[:, :2])
        foot[:, 2] = low + (y + half) / (2 * half) * (0.002 + top - low)
        points.append(foot @ R.T)
        normals.append(np.tile(R @ [1.0, 0, 0], (n * n, 1)))
    return np.concatenate(points), np.concatenate(normals)


@pytest.mark.parametrize("top", [0.08, 0.02], ids=["block", "book"])
@pytest.mark.parametrize(
    ("tilt", "bend"), [((0.0, 0.0), 0.0), ((0.02, -0.01), 0.0), ((0.01, 0.01), 0.2), ((0.0, 0.02), -0.2)]
)
def test_the_plate_goes_and_the_object_stays(tilt, bend, top):
    ground, height = plate(np.array(tilt), bend)
    ground = ground[np.abs(ground[:, :2]).max(axis=1) > 0.05]  # hidden below the block
    solid, solid_normals = block(top, height)
    vertices = np.concatenate([ground, solid])
    normals = np.concatenate([np.tile([0, 0, 1.0], (len(ground), 1)), solid_normals]).astype(np.float32)
    found = fitted_plate(Mesh(vertices, normals=normals), VOXEL, SIZE)
    # three standard deviations of noise and a voxel, and hardly any of the plate is higher
    assert 0.0009 < found.hidden < 0.0018
    above = found.height(vertices)
    assert (above[: len(ground)] > found.hidden).mean() < 0.002
    assert np.abs(above - (vertices[:, 2] - height(vertices[:, :2])))[: len(ground)].max() < 0.0003


@pytest.mark.parametrize("gap", [0.007, 0.014, 0.03])
def test_a_plate_goes_though_more_of_the_table_below_is_there(gap):
    ground, height = plate(np.array([0.004, -0.003]), 0.0)
    solid, solid_normals = block(0.08, height)
    wide = np.random.default_rng(3).uniform(-0.3, 0.3, (60_000, 2))
    table = np.column_stack([wide, np.full(len(wide), -gap)])
    vertices = np.concatenate([ground, table, solid])
    level = np.tile([0, 0, 1.0], (len(ground) + len(table), 1))
    normals = np.concatenate([level, solid_normals]).astype(np.float32)
    found = fitted_plate(Mesh(vertices, normals=normals), VOXEL, SIZE, -gap)
    assert found.hidden < 0.0018
    above = found.height(vertices)
    assert (above[: len(level)] > found.hidden).mean() < 0.002
    over = solid[:, 2] - height(solid[:, :2])
    assert np.abs(above[len(level) :] - over).max() < 0.0003


def test_a_plate_goes_where_a_wider_table_stands_close_below_it_and_was_not_told():
    ground, height = plate(np.array([0.004, -0.003]), 0.0)
    wide = np.random.default_rng(3).uniform(-0.3, 0.3, (80_000, 2))
    vertices = np.concatenate([ground, np.column_stack([wide, np.full(len(wide), -0.016)])])
    found = fitted_plate(Mesh(vertices, normals=np.tile(np.float32([0, 0, 1]), (len(vertices), 1))), VOXEL, SIZE)
    assert found.hidden < 0.0018
    assert np.abs(found.height(ground) - (ground[:, 2] - height(ground[:, :2]))).max() < 0.0003


def test_what_is_hidden_follows_the_noise_of_the_plate():
    found = []
    for noise in (0.0, 0.0003, 0.001):
        ground, _ = plate(np.zeros(2), 0.0, noise)
        level = np.tile(np.float32([0, 0, 1]), (len(ground), 1))
        found.append(fitted_plate(Mesh(ground, normals=level), VOXEL, SIZE).hidden)
    assert found[0] == pytest.approx(VOXEL, abs=1e-5)  # in the corner a voxel sees both
    assert found[0] < found[1] < found[2] < 0.0045


def test_coarse_counts_hide_more_than_their_median():
    ground, _ = plate(np.zeros(2), 0.0, 0.0)
    ground[::10, 2] -= 0.0008  # one in ten lies a count lower
    ground[5::10, 2] += 0.0008
    found = fitted_plate(Mesh(ground, normals=np.tile(np.float32([0, 0, 1]), (len(ground), 1))), VOXEL, SIZE)
    assert found.hidden > 0.0012


def standing(profile, tilt_deg=0.0, noise=0.0):
    """A body of revolution on a plate of 15 cm, as one surface, of points (radius, height) down to (radius, 0) [m]."""
    inner = np.array(profile, float)
    outline = [[0.0, inner[0, 1]], *inner, *([r, 0.0] for r in np.linspace(inner[-1, 0], 0.15, 80)[1:])]
    fine = []
    for a, b in itertools.pairwise(outline):
        step = VOXEL if fine else 3 * VOXEL  # in the middle of the top the sectors are fine enough
        fine.append(np.linspace(a, b, max(2, int(np.hypot(*np.subtract(b, a)) / step)))[:-1])
    radius, height = np.concatenate([*fine, [outline[-1]]]).T
    sectors = 240
    around = 2 * np.pi * np.arange(sectors) / sectors
    x, y = (np.outer(radius, f(around)).ravel() for f in (np.cos, np.sin))
    points = np.column_stack([x, y, np.repeat(height, sectors)])
    i, j = np.divmod(np.arange((len(radius) - 1) * sectors), sectors)
    a, b = i * sectors + j, i * sectors + (j + 1) % sectors
    faces = np.concatenate([np.column_stack([a, a + sectors, b]), np.column_stack([b, a + sectors, b + sectors])])
    slope = np.gradient(np.column_stack([radius, height]), axis=0)
    out = np.column_stack([-slope[:, 1], slope[:, 0]])
    out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-12)
    nr, nz = np.repeat(out, sectors, axis=0).T
    turned = np.tile(around, len(radius))
    normals = np.column_stack([nr * np.cos(turned), nr * np.sin(turned), nz])
    off = np.random.default_rng(4).normal(0, noise, len(points))
    off[:sectors] = 0  # one point in the middle
    points = points + normals * off[:, None]
    R = pose.about_axis((0, 0, 0), (1, 0.4, 0), np.deg2rad(tilt_deg))
    return Mesh(pose.transform(R, points), faces.astype(np.int32), (normals @ R[:3, :3].T).astype(np.float32)), R


BODIES = {
    "coin": ([(0.05, 0.006), (0.05, 0.0)], np.pi * 0.05**2 * 0.006),
    "mug": ([(0.04, 0.11), (0.04, 0.0)], np.pi * 0.04**2 * 0.11),
    "cone": ([(0.02, 0.03), (0.05, 0.0)], np.pi * 0.03 / 3 * (0.05**2 + 0.05 * 0.02 + 0.02**2)),
    "vase": ([(0.05, 0.04), (0.035, 0.0)], np.pi * 0.04 / 3 * (0.05**2 + 0.05 * 0.035 + 0.035**2)),
}


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize(("tilt", "noise"), [(0.0, 0.0), (0.0, 0.0003), (5.0, 0.0003)])
def test_the_object_stands_on_its_plate(body, tilt, noise):
    profile, volume = BODIES[body]
    surface, R = standing(profile, tilt, noise)
    motion = SimpleNamespace(plate=0.0, table=None, radius=0.15, size=SIZE)
    found = clean(surface, ScanSettings(), motion, VOXEL)
    height = pose.transform(pose.inverse(R), found.mesh.vertices)[:, 2]
    assert VOXEL <= found.hidden + 1e-5 < 0.0026
    assert height.min() == pytest.approx(0.0, abs=0.0003)  # a centimetre of 30 tells the plate to that
    shape = shape_of(found.mesh, UP)
    assert shape.openings() == "bottom open" and shape.fragments == 1
    # 0.2 mm all around is what noise leaves; a cut of 4 mm would take a tenth to two thirds
    assert shape.volume == pytest.approx(volume, abs=0.0002 * shape.area)
    edges = np.sort(found.mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert np.unique(edges, axis=0, return_counts=True)[1].max() == 2
    assert len(np.unique(found.mesh.faces)) == len(found.mesh.vertices)


def test_what_comes_too_flat_ends_where_it_was_seen():
    bowl = [(0.05 * np.sin(a), 0.0501 - 0.05 * np.cos(a)) for a in np.linspace(2.2, 0.15, 60)]
    surface, _ = standing([*bowl, (bowl[-1][0], 0.0)])
    found = clean(surface, ScanSettings(), SimpleNamespace(plate=0.0, table=None, radius=0.15, size=SIZE), VOXEL)
    assert found.mesh.vertices[:, 2].min() > -1e-6
    across = np.hypot(*found.mesh.vertices[:, :2].T)
    assert across[found.mesh.vertices[:, 2] < found.hidden].min(initial=1.0) > 0.006


def test_a_plate_that_stays_is_not_cut():
    surface, _ = standing(BODIES["mug"][0])
    motion = SimpleNamespace(plate=0.0, table=None, radius=0.14, size=SIZE)
    assert clean(surface, ScanSettings(keep_plate=True), motion, VOXEL).hidden == 0


@pytest.mark.parametrize("blur", [0.002, 0.004])
@pytest.mark.parametrize("waist", [0.04, 0.03], ids=["upright", "undercut"])
def test_a_corner_that_blur_rounds_is_cut_above(waist, blur):
    """Pixels that see side and plate together make a fillet of it, which is neither."""
    side, corner, level = np.array([[waist + (0.04 - waist) * blur / 0.11, blur], [waist, 0.0], [waist + blur, 0.0]])
    fillet = [tuple((1 - t) ** 2 * side + 2 * t * (1 - t) * corner + t**2 * level) for t in np.linspace(0, 1, 12)]
    surface, _ = standing([(0.04, 0.11), *fillet], noise=0.0001)
    found = clean(surface, ScanSettings(), SimpleNamespace(plate=0.0, table=None, radius=0.15, size=SIZE), VOXEL)
    assert found.hidden > 0.5 * blur
    foot = np.hypot(*found.mesh.vertices[found.mesh.vertices[:, 2] < 0.0003, :2].T)
    assert foot == pytest.approx(waist, abs=0.2 * blur)  # the fillet stands out by all of the blur


@pytest.mark.parametrize("lean", [0.0, 0.15, -0.15], ids=["upright", "tapered", "undercut"])
def test_a_corner_that_a_filter_rounds_is_cut_above(lean):
    """A recursive filter leaves an exponential: it fades over several times its length, and is nowhere steep."""
    z = np.linspace(0.03, 0.0, 40)
    side = [(0.04 - lean * (h - 0.03) + 0.0015 * np.exp(-h / 0.002), h) for h in z]
    surface, _ = standing([(side[0][0], 0.11), *side], noise=0.0001)
    found = clean(surface, ScanSettings(), SimpleNamespace(plate=0.0, table=None, radius=0.15, size=SIZE), VOXEL)
    low = found.mesh.vertices[found.mesh.vertices[:, 2] < 0.005]
    off = np.hypot(*low[:, :2].T) - (0.04 - lean * (low[:, 2] - 0.03))
    assert np.sqrt(np.mean(off**2)) < 0.0002  # noise of 0.1 mm, carried down a few millimetres
