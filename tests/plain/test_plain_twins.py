"""The tuned kernels against the plain ones, on whole images with noise, holes, edges and a bent lens.

What both round differently decides otherwise for a few pixels and voxels that lie on a limit; all others agree.
"""

import numpy as np
import pytest
import scenes

from fusion.geometry.camera import Camera
from fusion.geometry.depth import point_map
from fusion.geometry.pose import exp
from fusion.tracking.equations import PairLimits, equations, lay_out
from fusion.turntable.model import cells
from fusion.turntable.model.meeting import AXIS, HEIGHT, RESIDUAL, SHARED, SIGMA, SPOILT
from fusion.volume.blocks import by_voxel
from fusion.volume.extraction.surface import extract
from fusion.volume.volume import Volume, VolumeSettings

CAMERAS = {
    "bent": Camera(320, 240, 280.0, 281.0, 159.6, 120.7, (0.1, -0.05, 0.001, -0.002, 0.01)),
    "straight, odd": Camera(317, 239, 280.0, 280.0, 158.0, 119.0),
}
CENTRE, VOXEL, NOISE = np.array([0.010, -0.020, 0.013]), 0.006, 0.0005
POSES = [scenes.look_at(np.array([0.5, 0.1 * (1 + n), 0.2 - 0.05 * n]), CENTRE) for n in range(3)]


def both(monkeypatch, call):
    """What a call gives with tuned kernels, and with plain ones."""
    found = []
    for kind in ("tuned", "plain"):
        monkeypatch.setenv("FUSION_KERNELS", kind)
        found.append(call())
    return found


def images(camera):
    """Depth of a ball before a slanted wall at three poses, weights and colour."""
    rng = np.random.default_rng(0)
    depth = []
    for T in POSES:
        wall = scenes.plane(camera, T, np.array([-0.3, 0.0, 0.0]), np.array([0.9, 0.1, 0.3]))
        seen = np.fmin(wall, scenes.sphere(camera, T, CENTRE, 0.1))
        seen[seen > 1.5] = np.nan
        seen += rng.normal(0, NOISE, seen.shape).astype(np.float32)
        seen[rng.random(seen.shape) < 0.02] = np.nan
        depth.append(seen)
    weight = rng.uniform(0.5, 2, camera.shape).astype(np.float32)
    return depth, weight, rng.integers(0, 255, (*camera.shape, 3)).astype(np.uint8)


def fused(camera):
    depth, weight, color = images(camera)
    volume = Volume(VolumeSettings(VOXEL, 4 * VOXEL, color=True))
    for seen, T in zip(depth, POSES, strict=True):
        volume.integrate(seen, camera, T, weight, color)
    return volume


@pytest.fixture(scope="module", params=CAMERAS)
def camera(request):
    return CAMERAS[request.param]


@pytest.fixture(scope="module")
def volume(camera):
    return fused(camera)


def test_point_maps(monkeypatch, camera):
    depth = images(camera)[0][0]
    tuned, plain = both(monkeypatch, lambda: point_map(depth, camera, NOISE))
    assert np.array_equal(tuned.points, plain.points, equal_nan=True)
    assert (np.isfinite(tuned.normals) == np.isfinite(plain.normals)).mean() > 0.9999  # [px] on a limit
    # tuned arc cosines are a polynomial, to 3e-8, and normals sums in another order
    assert np.nanmax(np.abs(tuned.normals - plain.normals)) < 1e-3
    assert np.nanmax(np.abs(tuned.incidence - plain.incidence)) < 1e-3
    assert np.isfinite(plain.normals[..., 0]).mean() > 0.5


@pytest.mark.parametrize("limits", [PairLimits(0.05, scale=1.3), PairLimits(0.2, 0.5, open_to=0.2)])
def test_sums_of_pairs(monkeypatch, camera, limits):
    one, other = (point_map(depth, camera, NOISE) for depth in images(camera)[0][:2])
    source, T = lay_out(one, 40_000), exp([0.01, -0.02, 0.005, 0.01, 0.004, -0.01])
    tuned, plain = both(monkeypatch, lambda: equations(source, T, other, limits))
    assert plain.pairs > 1000
    for name in ("kept", "pairs", "visible"):
        assert getattr(tuned, name) == pytest.approx(getattr(plain, name), rel=1e-3)
    size = np.sqrt(np.diag(plain.information))
    assert (np.abs(tuned.information - plain.information) / np.outer(size, size)).max() < 1e-3
    least = np.sqrt(plain.squares / plain.kept * plain.weight)  # of a slope that residuals leave by chance, and more
    assert (np.abs(tuned.slope - plain.slope) / size).max() < 1e-3 * least
    assert tuned.squares == pytest.approx(plain.squares, rel=1e-3)
    assert tuned.scale == pytest.approx(plain.scale, rel=0.1)  # the tuned one is of 2000 pairs


def test_blocks_and_voxels(monkeypatch, camera):
    tuned, plain = (volume.blocks for volume in both(monkeypatch, lambda: fused(camera)))
    places = plain.coordinates[: plain.count]
    ids = tuned.find(places)
    # tuned boxes are around 4 x 4 pixels: they hold all of the plain ones, and some more
    assert (ids >= 0).all() and plain.count > 0.85 * tuned.count
    one, other = by_voxel(tuned.voxels[ids]), by_voxel(plain.voxels[: plain.count])
    # tuned planes keep slopes, scale and weight to one part in 256 each
    same = np.isclose(one, other, rtol=1e-2, atol=1e-5).all(axis=2)
    assert same.mean() > 0.99 and (other[..., 1] > 0).mean() > 0.2
    assert (tuned.solid[ids] == plain.solid[: plain.count]).mean() > 0.99
    assert np.isclose(tuned.colors[ids], plain.colors[: plain.count], rtol=2e-2, atol=0.1).mean() > 0.99


def test_raycasts(monkeypatch, camera, volume):
    tuned, plain = both(monkeypatch, lambda: volume.raycast(camera, POSES[0]))
    seen = np.isfinite(tuned.depth) & np.isfinite(plain.depth)
    # rays that graze what was never seen end on either side of it
    assert (np.isfinite(tuned.depth) != np.isfinite(plain.depth)).sum() < 0.03 * seen.sum()
    off = np.abs(tuned.depth - plain.depth)[seen] / VOXEL
    # tuned rays lie on curves through others where the surface is smooth
    assert np.median(off) < 0.03 and np.percentile(off, 95) < 0.2
    cosine = (tuned.normals * plain.normals).sum(axis=2)
    assert np.degrees(np.arccos(np.nanpercentile(cosine, 20))) < 5  # tuned ones are mostly taken from the depths
    assert np.nanmax(np.abs(plain.points[seen][:, 2] - plain.depth[seen])) == 0
    assert (np.abs(tuned.colors.astype(int) - plain.colors)[seen].max(axis=1) <= 1).mean() > 0.95


@pytest.mark.parametrize("least", [1e-6, 0.8])
def test_surfaces(monkeypatch, volume, least):
    tuned, plain = both(monkeypatch, lambda: extract(volume.blocks, least))
    assert len(plain.mesh.faces) > 1000
    for name in ("crossed", "triangles"):
        assert np.array_equal(getattr(tuned, name), getattr(plain, name))
    assert np.array_equal(tuned.mesh.faces, plain.mesh.faces)
    assert np.abs(tuned.mesh.vertices - plain.mesh.vertices).max() < 1e-7  # [m]
    assert np.abs(tuned.mesh.normals - plain.mesh.normals).max() < 1e-4
    assert np.abs(tuned.mesh.colors.astype(int) - plain.mesh.colors).max() <= 1


@pytest.mark.parametrize("steady", [False, True])
def test_sums_of_rays(monkeypatch, steady):
    rng, frames, count = np.random.default_rng(0), 7, 50
    each = rng.integers(1, 20, count)
    rows = rng.normal(0, 1, (each.sum(), SHARED + AXIS + 3)).astype(np.float32)
    rows[:, RESIDUAL] *= 0.002
    rows[:, SIGMA], rows[:, SPOILT], rows[:, HEIGHT] = 0.001, 1.5, rng.uniform(0, 0.1, len(rows))
    frame = np.concatenate([np.sort(rng.integers(0, frames, n)) for n in each]).astype(np.int32)
    first = np.append(0, np.cumsum(each)).astype(np.int32)
    how = (1.2, steady, 0.03 if steady else -np.inf)
    tuned, plain = both(monkeypatch, lambda: cells.normal_equations(rows, frame, first, np.zeros(count), frames, how))
    for one, other in zip(tuned, plain, strict=True):
        assert np.abs(other).max() > 0
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9 * np.abs(other).max())
