"""Rough places: noise alone says nothing, a torn or bent surface does, and a wrong sigma as a whole changes nothing."""

import numpy as np
import pytest

from fusion.turntable.model.rays import HALF, shared_errors

SHAPE = (60, 80)
SIGMA = 0.001


def slanted(seed=0):
    v, u = np.indices(SHAPE)
    noise = np.random.default_rng(seed).normal(0, SIGMA, SHAPE)
    return (0.8 + 0.002 * u - 0.001 * v + noise).astype(np.float32)


def errors(depth, sigma=SIGMA, taken=None):
    spread = np.full(SHAPE, sigma, np.float32)
    return shared_errors(depth, spread, np.isfinite(depth) if taken is None else taken)


def test_noise_on_a_plane_is_no_shared_error():
    found = errors(slanted())
    assert (found >= 0).all()
    # limited to what two standard deviations exceed: 2.3 % of the windows
    assert (found > 0).mean() < 0.06


def test_a_step_within_a_surface_is_found_where_windows_hold_it():
    depth = slanted()
    depth[:, 40:] += np.float32(0.010)
    found = errors(depth)
    assert (found[10:-10, 40 - HALF + 1 : 40 + HALF - 1] > 1).all()
    away = np.abs(np.arange(SHAPE[1]) - 39.5) > HALF + 1
    assert (found[:, away] > 0).mean() < 0.06


@pytest.mark.parametrize("factor", [0.1, 10.0])
def test_a_sigma_that_is_wrong_as_a_whole_changes_nothing(factor):
    depth = slanted()
    depth[20:23, 30:33] += np.float32(0.004)
    # float32 depths
    np.testing.assert_allclose(errors(depth, factor * SIGMA), errors(depth), rtol=1e-3, atol=1e-3)


def test_what_is_not_taken_says_nothing():
    depth = slanted()
    taken = np.ones(SHAPE, bool)
    taken[:, 40:] = False
    other = depth.copy()
    other[:, 40:] = np.nan
    np.testing.assert_array_equal(errors(depth, taken=taken), errors(other, taken=taken))
    assert not errors(depth, taken=taken)[:, 40:].any()


def test_empty_and_single_rows_give_zero():
    assert not errors(np.full(SHAPE, np.nan, np.float32)).any()
    row = np.zeros(SHAPE, bool)
    row[30] = True
    assert not errors(slanted(), taken=row).any()
