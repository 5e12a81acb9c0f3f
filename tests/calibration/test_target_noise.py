"""Noise on a flat target: what was put in is measured."""

import numpy as np
import pytest

from fusion.calibration.noise.edge import spread_with_error
from fusion.calibration.noise.target import find_target
from fusion.calibration.noise.target_noise import measure_target
from fusion.calibration.series import PixelSeries
from fusion.errors import FusionError
from fusion.geometry.camera import Camera

CAMERA = Camera(160, 120, 365.0, 365.0, 79.5, 59.5, principle="itof")
SIGMA, JITTER = 0.002, 0.7  # [m], [px]
FRAMES = 60


def wall(tilt_deg: float, distance: float = 1.2) -> np.ndarray:
    """(h, w) depth of a plane turned about the vertical [m]."""
    t = np.deg2rad(tilt_deg)
    n = np.array([np.sin(t), 0.0, -np.cos(t)])
    rays = np.dstack([CAMERA.rays(), np.ones(CAMERA.shape)])
    return n[2] * distance / (rays @ n)


def frames(tilt_deg: float, rng: np.random.Generator) -> list[np.ndarray]:
    """A target between two leaning edges that jitter row by row, a wall 1 m behind it."""
    v, u = np.mgrid[0:120, 0:160]
    out = []
    for _ in range(FRAMES):
        left = 40.2 + 0.05 * v + JITTER * rng.standard_normal((120, 1))
        right = 118.4 + 0.05 * v + JITTER * rng.standard_normal((120, 1))
        on = (u > left) & (u < right) & (v > 15) & (v < 105)
        out.append(np.where(on, wall(tilt_deg) + SIGMA * rng.standard_normal(u.shape), 2.6))
    return out


@pytest.mark.parametrize("tilt", [0, 40, 65])
def test_what_was_put_in_is_measured(tilt):
    found = measure_target(frames(tilt, np.random.default_rng(tilt)), CAMERA)
    assert found.frames == FRAMES
    # four standard errors, as the result states its own
    assert abs(found.axial - SIGMA) < 4 * found.axial_std < 0.05 * SIGMA
    # the middle of the target is within a few pixels of the optical axis
    assert abs(np.rad2deg(found.tilt) - tilt) < 1.5
    # 60 frames of some 60 rows: 1.2 % of one spread
    expected = JITTER * np.array(found.edge_depth) / CAMERA.fx
    assert np.allclose(found.lateral, expected, rtol=0.05)
    assert found.valid > 0.999 and found.outliers < 1e-3


def test_holes_and_outliers_are_counted():
    rng = np.random.default_rng(0)
    series = frames(0, rng)
    target = find_target(series[0], CAMERA)
    for depth in series:
        chance = rng.random(depth.shape)
        depth[chance < 0.2] = np.nan
        depth[chance > 0.9] += 0.4
    found = measure_target(series, CAMERA, target, sigma=SIGMA)
    assert np.allclose([found.valid, found.no_data, found.outliers], [0.7, 0.2, 0.1], atol=0.01)  # some 10^5 pixels


@pytest.mark.parametrize("share", [0.05, 0.15])
def test_holes_are_no_jitter_of_an_edge(share):
    rng = np.random.default_rng(4)
    series = frames(0, rng)
    target = find_target(series[0], CAMERA)
    for depth in series:
        depth[rng.random(depth.shape) < share] = np.nan
    found = measure_target(series, CAMERA, target, sigma=SIGMA)
    expected = JITTER * np.array(found.edge_depth) / CAMERA.fx
    assert np.allclose(found.lateral, expected, rtol=0.12)


@pytest.mark.parametrize("tilt", [0, 40])
def test_the_step_of_the_rounding_is_found_at_any_tilt(tilt):
    rng, step = np.random.default_rng(5), 0.001
    near = wall(tilt) + 0.0003  # a frontal one between two counts, where few values change
    series = [np.round((near + 0.0002 * rng.standard_normal(near.shape)) / step) * step for _ in range(FRAMES)]
    assert measure_target(series, CAMERA).step == pytest.approx(step, rel=0.05)


def test_the_pixel_grid_is_taken_out_of_the_spread():
    rng = np.random.default_rng(3)
    rows = np.linspace(0, 7.3, 120)
    for sigma in (0.0, 0.3, 1.0):
        seen = np.round(30 + rows + sigma * rng.standard_normal((400, 120)))
        assert spread_with_error(seen)[0] == pytest.approx(sigma, abs=0.03)


@pytest.mark.parametrize("image", [np.full((120, 160), np.nan), np.random.default_rng(0).uniform(0.5, 5, (120, 160))])
def test_an_image_without_a_target_is_refused(image):
    with pytest.raises(FusionError, match="no target found"):
        find_target(image, CAMERA)


def test_one_frame_has_no_noise():
    with pytest.raises(FusionError, match="too few frames"):
        measure_target([wall(0)], CAMERA)


def test_a_series_is_that_of_numpy():
    rng = np.random.default_rng(1)
    images = 1e3 + rng.standard_normal((20, 6, 8))
    images[rng.random(images.shape) < 0.3] = np.nan
    images[:, 0, 0] = np.nan
    series = PixelSeries((6, 8))
    for image in images:
        series.add(image)
    known = np.arange(48).reshape(6, 8) > 0
    assert np.allclose(series.mean[known], np.nanmean(images[:, known], axis=0), rtol=1e-12)
    assert np.allclose(series.std[known], np.nanstd(images[:, known], axis=0, ddof=1), rtol=1e-9)
    assert np.isnan(series.mean[0, 0]) and series.valid[0, 0] == 0
