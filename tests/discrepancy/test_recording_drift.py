"""A smooth error that every recording has for itself is no law; neighbours that share noise, and a handful of tiles."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_walls import looks_at, loose_in, sensor_of
from scipy.ndimage import gaussian_filter

from fusion.discrepancy.explain import explained_looks
from fusion.discrepancy.inference.covariance import drifting, neighbours
from fusion.discrepancy.naming.evidence import by_chance
from fusion.discrepancy.naming.search.score import Scored
from fusion.sensor.effects.readout.depth_scale import DepthScale

DRIFT = 0.001  # [m] five times the mean of the frames of a pixel, ten times that of a tile and more


def drifted(sensor, seed: int):
    """Blocks of which each has a smooth error of its own, some 20 px wide."""
    rng = np.random.default_rng(seed)
    out = []
    for block in looks_at(sensor, seed):
        field = gaussian_filter(rng.standard_normal(block.mean.shape), 20.0, mode="wrap")
        out.append(replace(block, mean=block.mean + DRIFT * field / field.std()))
    return out


def test_recordings_that_drift_are_told_from_laws():
    # the lengths over which it changes are a guess, and what laws could follow is left out: known to a factor
    assert DRIFT / 3 < loose_in(drifted(sensor_of("itof"), 1)).drift < 3 * DRIFT
    assert loose_in(looks_at(sensor_of("itof"), 1)).drift == 0.0
    assert loose_in(looks_at(sensor_of("itof", DepthScale(scale=0.01)), 1)).drift == 0.0


@pytest.mark.slow
def test_no_law_is_made_of_drift():
    found = explained_looks(drifted(sensor_of("itof"), 2), sensor_of("itof"))
    assert DRIFT / 3 < found.before.loose.drift < 3 * DRIFT  # as above
    assert not found.named.steps
    assert not found.unknown


def test_a_drift_has_unit_spread_and_is_smooth():
    at = np.stack(np.meshgrid(np.arange(8, 112, 16), np.arange(8, 80, 16)), axis=-1).reshape(-1, 2).astype(float)
    covariance = drifting(at, 16.0, 112.0) @ drifting(at, 16.0, 112.0).T
    # the directions left out hold a thousandth of the largest each
    assert np.diag(covariance) == pytest.approx(1.0, abs=0.05)
    assert covariance[0, 1] > covariance[0, 3] > covariance[0, 6] > 0


def test_neighbours_that_share_noise_vary_more_together():
    rng = np.random.default_rng(0)
    noise = gaussian_filter(rng.standard_normal((400, 16, 16)), (0, 0.7, 0.7), mode="wrap")
    alike = np.array([[np.mean(noise * np.roll(noise, k, axis)) for k in range(9)] for axis in (2, 1)])
    alike /= np.mean(noise**2)
    # the filter keeps the sum of all pixels: on a torus the mean varies as if nothing was filtered
    grown = 1.0 / 256 / np.mean(noise**2)
    assert neighbours(alike, 16) == pytest.approx(256 * grown, rel=0.15)
    assert neighbours(np.eye(9)[:1].repeat(2, axis=0), 16) == 1.0


def test_a_handful_of_tiles_is_a_handful_of_numbers():
    target = np.random.default_rng(1).standard_normal(600)
    few, many = np.zeros(600), np.full(600, 5.0 / np.sqrt(600))
    few[:5] = 5.0 / np.sqrt(5)
    found = Scored(25.0, 20.0, np.ones(1), 0.0, 1)
    assert by_chance(found, many, target + many, 1) < 1e-5 < 1e-3 < by_chance(found, few, target + few, 1)
