"""The fused kernel against plain numpy, and what interpolation is for: the raster leaves no mark."""

import numpy as np
import pytest
from small_room import CAMERA, SIGMA

from fusion.geometry.camera import Camera
from fusion.geometry.depth import PointMap, point_map
from fusion.geometry.pose import exp, inverse
from fusion.tracking.equations import LATERAL, PairLimits, equations, lay_out, thinned
from fusion.tracking.icp import align


@pytest.fixture(autouse=True, params=["tuned", "plain"])
def kernels(request, monkeypatch):
    """All of it holds for both."""
    monkeypatch.setenv("FUSION_KERNELS", request.param)


def twin(source, T, model, limits):
    """(7, 7) sums of [J r]^T [J r] weighted, and the numbers of pairs and of visible points, point by point."""
    camera, total, pairs, visible = model.camera, np.zeros((7, 7)), 0, 0
    z = model.points[..., 2]
    centre = T[:3, :3] @ source.centre + T[:3, 3]
    for p in np.moveaxis(source.lanes, 1, 2).reshape(-1, 7)[: source.count].astype(float):
        q, m = T[:3, :3] @ p[:3] + T[:3, 3], T[:3, :3] @ p[3:6]
        u, v = camera.project(q)[0]
        if not (0 <= u <= camera.width - 1 and 0 <= v <= camera.height - 1):
            continue
        i, j = min(int(v), camera.height - 2), min(int(u), camera.width - 2)
        four = z[i : i + 2, j : j + 2].astype(float)
        b, a = v - i, u - j
        met = 1 / ((1 - b) * ((1 - a) / four[0, 0] + a / four[0, 1]) + b * ((1 - a) / four[1, 0] + a / four[1, 1]))
        if not (np.ptp(four) < 12 * met / camera.fx):
            continue
        visible += 1
        n = model.normals[round(v), round(u)].astype(float)
        if np.linalg.norm(q * (1 - met / q[2])) >= limits.reach or not m @ n > limits.min_cosine:
            continue
        pairs += 1
        r, cosine = n @ q * (1 - met / q[2]), n @ q / np.linalg.norm(q)
        aslant = (1 - cosine**2) * (LATERAL * q[2] / camera.fx) ** 2
        spread = limits.scale * np.sqrt(cosine**2 * p[6] ** 2 + aslant)
        weight = max(1 - (r / max(4.685 * spread, limits.open_to)) ** 2, 0) ** 2 / spread**2
        row = np.array([*np.cross(q - centre, n), *n, r])
        total += weight * np.outer(row, row)
    return total, pairs, visible


@pytest.mark.parametrize("limits", [PairLimits(0.05, scale=1.3), PairLimits(0.2, 0.5, open_to=0.2)])
def test_the_kernel_sums_what_numpy_sums(room, limits):
    source, model = lay_out(room.frame(np.eye(4), 1), 400), room.model(np.eye(4))
    T = exp([0.01, -0.02, 0.005, 0.01, 0.004, -0.01])
    sums = equations(source, T, model, limits)
    total, pairs, visible = twin(source, T, model, limits)
    # single precision decides otherwise for a few points that lie on a limit
    assert abs(sums.pairs - pairs) <= 0.003 * source.count
    assert abs(sums.visible - visible) <= 0.003 * source.count
    scale = np.sqrt(np.diag(total))
    found = np.zeros((7, 7))
    found[:6, :6], found[6, :6] = sums.information, sums.slope
    assert np.abs((found - total) / np.outer(scale, scale))[:, :6][:6].max() < 0.01
    assert np.abs((found - total) / np.outer(scale, scale))[6, :6].max() < 0.01


def test_points_are_laid_out_once_each(room):
    frame = room.frame(np.eye(4), 1)
    known = np.isfinite(frame.normals[..., 0])
    every = lay_out(frame, 10**6)
    assert every.count == known.sum()
    assert every.centre == pytest.approx(frame.points[known].mean(axis=0), abs=1e-5)
    assert every.radius == pytest.approx(np.sqrt(frame.points[known].var(axis=0).sum()), abs=1e-5)
    assert 1000 <= lay_out(frame, 1000).count <= 4000  # strides are whole numbers
    assert thinned(every, 500).count >= 500
    nothing = np.full((*CAMERA.shape, 3), np.nan, np.float32)
    assert lay_out(PointMap(CAMERA, nothing, nothing.copy(), nothing[..., 0].copy()), 100).count == 0


def test_the_raster_leaves_no_mark(room):
    """Without noise a coarse image aligns to a hundredth of its pixels, which are 1 cm wide."""
    true = exp([0.01, -0.015, 0.005, 0.013, 0.007, -0.011])
    frame = point_map(room.depth(true), CAMERA, SIGMA)
    found = align(frame, room.model(np.eye(4)), np.eye(4)).T_model_source
    assert np.linalg.norm((inverse(true) @ found)[:3, 3]) < 1e-4


def test_an_image_of_one_row_is_no_model(room):
    thin = Camera(160, 1, 144.0, 144.0, 80.0, 0.0)
    row = np.ones((1, 160, 3), np.float32)
    result = align(room.frame(np.eye(4)), PointMap(thin, row, row, row[..., 0]), np.eye(4))
    assert result.status == "only 0 points met the model"
