"""Rounding at a pose that is not exactly the stated one: its steps lie elsewhere, and nothing is missing."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_walls import WALLS, look_at, looks_at

from fusion.discrepancy.channels.scatter import WANDERS, scatter_of
from fusion.discrepancy.inference.rounding import _added, rounding_covariance
from fusion.discrepancy.inference.tile_covariance import MeasuredTiles, covariance_of
from fusion.discrepancy.naming.search.bounds import tweaked
from fusion.discrepancy.naming.search.candidates import candidates_of
from fusion.discrepancy.naming.search.space import Aim, Space
from fusion.discrepancy.observe.observations import observe
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.depth_quantization import DepthQuantization
from fusion.sensor.effects.triangulation.disparity_offset import DisparityOffset
from fusion.sensor.effects.triangulation.speckle_noise import SpeckleNoise
from fusion.sensor.sensor import Sensor
from fusion.sensor.where import Bound

COARSE = [
    Sensor("coarse", "structured_light", (AxialNoise(sigma_px=0.02), DepthQuantization(step_px=0.125))),
    Sensor("coarse", "itof", (AxialNoise(c0=0.001), DepthQuantization(step=0.008))),
]


@pytest.mark.parametrize("sensor", COARSE, ids=lambda sensor: sensor.principle)
def test_residuals_are_as_large_as_steps_elsewhere_make_them(sensor):
    calm = []
    for seed in range(4):
        observations = observe(sensor, looks_at(sensor, seed))
        white = covariance_of(observations).whiten(observations.residual)
        calm.append(float(white @ white) / len(white))
    assert np.mean(calm) < 1.5, calm  # without these columns: far above


@pytest.mark.parametrize("sensor", COARSE, ids=lambda sensor: sensor.principle)
def test_what_is_known_exactly_is_rounded_as_predicted(sensor):
    observations = observe(sensor, looks_at(sensor, 1))
    n = len(observations.residual)
    assert np.abs(rounding_covariance(observations, *np.zeros((2, n, n)))).max() < 1e-15


@pytest.mark.parametrize("sensor", COARSE, ids=lambda sensor: sensor.principle)
def test_noise_that_is_larger_than_stated_smooths_the_steps_as_far_as_it_is_doubted(sensor):
    """What the mean changes by noise that is a tenth larger, along the one direction that the covariance has for it."""
    louder = {"c0": 1.1 * sensor.effects[0].c0, "sigma_px": 1.1 * sensor.effects[0].sigma_px}
    other = replace(sensor, effects=(replace(sensor.effects[0], **louder), *sensor.effects[1:]))
    blocks = [replace(block, std=np.full_like(block.std, np.nan)) for block in looks_at(sensor, 1)]
    observations = observe(sensor, blocks)
    n = len(observations.residual)
    changed = observations.residual - observations.under(other).residual
    total = rounding_covariance(observations, *np.zeros((2, n, n)), doubt=0.1)
    assert np.sqrt(np.diag(total)) == pytest.approx(np.abs(changed), abs=0.2 * np.abs(changed).max())
    assert np.linalg.matrix_rank(total, tol=1e-6 * np.linalg.norm(total)) == 1


def test_noise_that_is_large_beside_the_step_hides_it():
    dithered = replace(COARSE[0], effects=(AxialNoise(sigma_px=0.1), DepthQuantization(step_px=0.125)))
    observations = observe(dithered, looks_at(dithered, 1))
    n = len(observations.residual)
    assert not np.any(rounding_covariance(observations, np.eye(n), np.zeros((n, n))))


def test_products_are_those_of_many_draws():
    rng = np.random.default_rng(1)
    waves, root = rng.normal(size=(5, 2)) + 1j * rng.normal(size=(5, 2)), rng.normal(size=(5, 5))
    turns, law = rng.uniform(0.2, 0.6, 5), rng.normal(size=(5, 5))
    e, more = (rng.normal(size=(200_000, 5)) @ one.T for one in (root, law))

    def behind(x):
        return x + (waves * np.exp(1j * turns[:, None] * [1, 2] * x[..., None])).imag.sum(axis=-1)

    off = behind(e) - behind(np.zeros(5))
    whole, nothing = root @ root.T, np.zeros((5, 5))
    assert whole + _added(waves, turns, whole, nothing) == pytest.approx(off.T @ off / len(e), abs=0.1)  # 10 std
    off = behind(e + more) - behind(np.zeros(5))
    slopes = np.mean((off * (e + more)), axis=0) / np.diag(whole + law @ law.T)
    off = off.T @ off / len(e) - np.outer(slopes, slopes) * (law @ law.T)
    assert whole + _added(waves, turns, whole, law @ law.T) == pytest.approx(off, abs=0.3)


def test_speckle_moves_pixels_to_other_steps():
    """Without noise a little speckle makes whole steps: tiles scatter by far more than by speckle alone."""
    rounding, noise = DepthQuantization(step_px=0.25), AxialNoise(sigma_px=0.004)
    sensor = Sensor("calm", "structured_light", (SpeckleNoise(sigma_px=0.02, correlation_px=4.0), noise, rounding))
    calm = []
    for seed in range(4):
        # placements of one seed differ in their speckle
        blocks = [look_at(sensor, place, wall, seed, placement=10 * seed + place) for place, wall in enumerate(WALLS)]
        observations = observe(sensor, blocks)
        white = covariance_of(observations).whiten(observations.residual)
        calm.append(float(white @ white) / len(white))
    assert 0.3 < np.mean(calm) < 1.5, calm


def test_frames_amid_one_step_scatter_less_by_no_more_than_steps_hide():
    """No frame of a pixel leaves its step: that is no noise of a 1e-13th, which no sum of tiles outweighs."""
    sensor = Sensor("made up", "structured_light", (AxialNoise(sigma_px=0.02), DepthQuantization(step_px=0.05)))
    blocks = [replace(block, std=np.zeros_like(block.mean)) for block in looks_at(sensor, 1)]
    scatter = scatter_of(observe(sensor, blocks).patches)
    # the model has variance of its own, twice as much as rounding alone makes
    assert -WANDERS - np.log(4.0) < scatter.excess.min() < scatter.excess.max() < -WANDERS


def test_a_tile_amid_one_step_tells_nothing_of_a_law():
    sensor = Sensor("calm", "structured_light", (AxialNoise(sigma_px=0.002), DepthQuantization(step_px=0.25)))
    tilted, frontal = observe(sensor, looks_at(sensor, 1, [(0.8, 30, 17), (3.65, 0, 0)])).patches
    offset = DisparityOffset(offset=0.02)
    assert np.mean(np.abs(tilted.column(offset))) == pytest.approx(0.02, rel=0.1)
    assert np.max(np.abs(frontal.column(offset))) < 0.001


def test_a_law_is_the_same_behind_a_rounding_whether_a_region_ends_or_not():
    sensor = Sensor("calm", "structured_light", (AxialNoise(sigma_px=0.002), DepthQuantization(step_px=0.25)))
    observations = observe(sensor, looks_at(sensor, 1, [(0.8, 30, 17), (3.65, 0, 0)]))
    covariance = covariance_of(observations)
    whole = next(c for c in candidates_of(observations, covariance) if c.name == "disparity_offset")
    aim = Aim(Space(np.zeros((len(observations.residual), 0)), np.zeros(0)), whole.white[:, 0])
    depth = np.linspace(0.5, 4.0, len(observations.residual))
    everywhere = tweaked(whole, Bound("depth", -np.inf, np.inf), depth, MeasuredTiles(observations, covariance), aim)
    assert everywhere.columns == pytest.approx(whole.columns)
