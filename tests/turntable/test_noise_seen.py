"""The noise of a recording by itself."""

import numpy as np
import pytest

from fusion.turntable.turning.noise_seen import noise_over_stated

STATED = 0.001  # [m]


def stated(depth):
    return np.where(np.isfinite(depth), np.float32(STATED), np.float32(np.nan))


def walls(noise, seed=0):
    """(6, 60, 160) images of two slanted walls [m], the right one three times as far."""
    u, v = np.meshgrid(np.arange(160.0), np.arange(60.0))
    depth = np.where(u < 80, 0.8 + 0.001 * u, 2.4 + 0.002 * u + 0.001 * v)
    rng = np.random.default_rng(seed)
    images = depth + np.where(u < 80, noise[0], noise[1]) * rng.standard_normal((6, 60, 160))
    images[:, 5:9] = np.nan
    return images.astype(np.float32), depth.astype(np.float32)


def test_noise_is_told_where_it_is():
    images, depth = walls((STATED, 8 * STATED))
    found = noise_over_stated(images, stated, depth)
    assert np.median(found[:, :80]) == pytest.approx(1, abs=0.1)
    assert np.median(found[:, 80:]) == pytest.approx(8, rel=0.1)
    assert np.isfinite(found).all()


def test_less_noise_than_stated_leaves_what_is_stated():
    images, depth = walls((0.1 * STATED, 0.1 * STATED))
    assert (noise_over_stated(images, stated, depth) == 1).all()


def test_few_pixels_tell_nothing():
    images, depth = walls((9 * STATED, 9 * STATED))
    assert (noise_over_stated(images[:, :10, :10], stated, depth[:10, :10]) == 1).all()
    assert (noise_over_stated(np.full_like(images, np.nan), stated, depth) == 1).all()
