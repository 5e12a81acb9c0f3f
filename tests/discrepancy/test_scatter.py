"""Tiles that scatter for themselves: told apart from laws, and no reason to see laws that are not there."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_walls import looks_at, sensor_of

from fusion.discrepancy.explain import explained_looks
from fusion.discrepancy.inference.scatter import beside_laws, loose_of
from fusion.discrepancy.inference.sizes import orthonormal
from fusion.discrepancy.inference.tile_covariance import covariance_of, drift_columns
from fusion.discrepancy.naming.search.candidates import candidates_of
from fusion.discrepancy.observe.observations import observe
from fusion.discrepancy.unknown.unrestricted import groups_of
from fusion.sensor.effects.readout.depth_scale import DepthScale

SCATTER = 0.004  # [m] far above the tiles' own noise of 0.1 mm


def scattered(sensor, seed: int):
    """Blocks whose squares of 16 px are each off by an amount of their own."""
    rng = np.random.default_rng(seed)
    out = []
    for block in looks_at(sensor, seed):
        h, w = block.mean.shape
        off = rng.normal(0, SCATTER, (-(-h // 16), -(-w // 16)))
        out.append(replace(block, mean=block.mean + np.kron(off, np.ones((16, 16)))[:h, :w]))
    return out


def scatter_in(blocks) -> float:
    observations = observe(sensor_of("itof"), blocks)
    covariance = covariance_of(observations)
    return loose_of(
        observations, covariance, candidates_of(observations, covariance), groups_of(observations, covariance)
    ).scatter


@pytest.mark.slow
def test_scatter_is_found_and_no_law_is_named():
    found = explained_looks(scattered(sensor_of("itof"), 1), sensor_of("itof"))
    # a few hundred tiles tell a standard deviation to 10 %; those in the span of a law take part of it with them
    assert found.before.loose.scatter == pytest.approx(SCATTER, rel=0.4)
    assert not found.named.steps
    assert not found.unknown


@pytest.mark.slow
def test_a_strong_law_is_no_scatter():
    far_off = sensor_of("itof", DepthScale(scale=0.03))
    assert scatter_in(looks_at(far_off, 4)) == 0.0
    assert scatter_in(scattered(far_off, 3)) == pytest.approx(SCATTER, rel=0.4)


def test_what_laws_follow_wholly_is_gone_but_for_nothing():
    """What is left of it is rounding, which was blown up as the size of a part until numbers ran over."""
    observations = observe(sensor_of("itof"), scattered(sensor_of("itof"), 3)[:2])
    covariance = covariance_of(observations)
    some = np.random.default_rng(2).normal(size=(len(observations.residual), 5)) * 1e-3
    basis = orthonormal(covariance.whiten(some))
    assert not beside_laws(covariance, basis, some[:, :3] @ np.ones((3, 2))).any()
    other = drift_columns(observations)[:, :4]
    assert beside_laws(covariance, basis, other).all(axis=0).all()
