"""Colour cameras settled by print: a known error is found, none is made up."""

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.pose import exp, inverse, transform
from fusion.texture.settled import FARTHEST, settled, twist_of, without_common

CAMERA = Camera(320, 240, 300.0, 301.0, 160.3, 119.1)
TRUE = exp([0.1, -0.2, 0.05, 0.02, 0.01, -0.03])


def bumpy(x, y):
    """Depth [m] of a surface before the camera, so that turning and moving differ."""
    return 0.6 + 0.05 * np.sin(20 * x) * np.cos(17 * y)


def print_at(x, y):
    """Fine colours at places on it."""
    rng = np.random.default_rng(3)
    waves = [np.sin(rng.normal(0, 250) * x + rng.normal(0, 250) * y + rng.uniform(0, 6)) for _ in range(12)]
    return np.stack([sum(waves[i::3]) for i in range(3)], axis=-1) * 15


def look():
    """The image from the true place, and points of the surface in the world with their colours."""
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    x, y = ((u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy)  # steepness names a place
    high = print_at(0.6 * x, 0.6 * y).astype(np.float32)
    rng = np.random.default_rng(0)
    a, b = rng.uniform(-0.4, 0.4, 4000), rng.uniform(-0.3, 0.3, 4000)
    z = bumpy(0.6 * a, 0.6 * b)
    points = transform(TRUE, np.column_stack([a * z, b * z, z]))
    return high, points, print_at(0.6 * a, 0.6 * b).astype(np.float32)


def off_by(T, points):
    """Median distance [px] of where points fall from where they truly do."""
    fall = [CAMERA.project(transform(inverse(one), points)) for one in (T, TRUE)]
    return float(np.median(np.linalg.norm(fall[0] - fall[1], axis=1)))


@pytest.mark.parametrize("seed", range(4))
def test_an_error_of_two_pixels_is_found(seed):
    high, points, colors = look()
    rng = np.random.default_rng(seed)
    stated = TRUE @ exp([*rng.normal(0, 0.0015, 3), *rng.normal(0, 0.0015, 3)])
    before = off_by(stated, points)
    after = off_by(settled(CAMERA, high, stated, stated, points, colors), points)
    assert before > 0.3 and after < 0.1  # of bilinear looks into print of some pixels


def test_where_nothing_is_printed_it_stays():
    high, points, _ = look()
    stated = TRUE @ exp([0.002, 0, 0, 0, 0.002, 0])
    noise = np.random.default_rng(0).normal(0, 2, (*high.shape,)).astype(np.float32)
    plain = np.zeros((len(points), 3), np.float32)
    moved = settled(CAMERA, noise, stated, stated, points, plain)
    assert abs(off_by(moved, points) - off_by(stated, points)) < 0.5
    few = settled(CAMERA, high, stated, stated, points[:20], plain[:20])
    np.testing.assert_array_equal(few, stated)


def test_never_far_from_where_the_depth_says():
    high, points, colors = look()
    stated = TRUE @ exp([0.03, 0.0, 0, 0, 0, 0])  # nine pixels: print repeats
    moved = settled(CAMERA, high, stated, stated, points, colors)
    fall = [CAMERA.project(transform(inverse(one), points)) for one in (moved, stated)]
    assert np.median(np.linalg.norm(fall[0] - fall[1], axis=1)) <= FARTHEST


def test_what_all_cameras_share_is_taken_back():
    rng = np.random.default_rng(0)
    stated = np.stack([exp([0, 0, a, np.cos(a), np.sin(a), 0.3]) for a in np.linspace(0, 6, 9)])
    own = rng.normal(0, 1e-3, (9, 6))
    own -= own.mean(axis=0)
    moved = np.stack(
        [S @ exp(np.array([2e-3, -1e-3, 0, 1e-3, 0, 3e-3]) + one) for S, one in zip(stated, own, strict=True)]
    )
    left = np.array([twist_of(inverse(S) @ T) for S, T in zip(stated, without_common(moved, stated), strict=True)])
    assert np.abs(left.mean(axis=0)).max() < 2e-4 and np.abs(left).max() < 4e-3
