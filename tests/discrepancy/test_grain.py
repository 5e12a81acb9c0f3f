"""Grain: what pixels keep for themselves is told from noise by frames that took no part."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_walls import HEIGHT, WALLS, WIDTH, look_at, sensor_of

from fusion.discrepancy.channels.grain import APART_PX, _as_seen, with_grain
from fusion.discrepancy.explain import explained_looks
from fusion.discrepancy.observe.observations import observe
from fusion.sensor.effects.optics.lens_distortion import LensDistortion
from fusion.sensor.effects.readout.depth_quantization import DepthQuantization
from fusion.sensor.effects.readout.fixed_pattern import FixedPattern
from fusion.sensor.effects.triangulation.pixel_locking import PixelLocking
from fusion.sensor.effects.triangulation.speckle_noise import SpeckleNoise
from fusion.sensor.laws.fields import windowed
from fusion.sensor.sensor import Sensor


def grainy(given: Sensor, effect, seed=1, off=1.0):
    """Walls whose frames, fitted and held out, have one effect more in common."""
    blocks = []
    for place, wall in enumerate(WALLS):
        one, other = (look_at(given, place, wall, seed + 50 * k, off=0.0) for k in (0, 1))
        stage = one.stage
        stage.sigma_m = stage.sigma_rad = 0.001 * off
        view = replace(one.view, moment=replace(one.view.moment, unit=seed, placement=100 * seed + place))
        more = 0.0 if effect is None else effect.bias(one.view.depth, view)
        held = replace(other, stage=stage, mean=other.mean + more)
        blocks.append(replace(one, mean=one.mean + more, held=held))
    return blocks


@pytest.mark.parametrize("window", [3.0, 5.0])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_speckle_is_found_with_its_size_and_its_window(window, seed):
    given = sensor_of("structured_light")
    blocks = grainy(given, SpeckleNoise(sigma_px=0.05, correlation_px=window), seed)
    (step,) = with_grain(observe(given, blocks))[1]
    assert step.effect.name == "speckle_noise"
    assert step.effect.sigma_px == pytest.approx(0.05, rel=0.08)  # a tenth as many independent pixels as tiles have
    assert step.effect.correlation_px == pytest.approx(window, rel=0.25)


@pytest.mark.parametrize(("principle", "size"), [("itof", 0.002), ("structured_light", 0.003)])
def test_a_pattern_that_all_recordings_share_is_one_of_the_unit(principle, size):
    given = sensor_of(principle)
    (step,) = with_grain(observe(given, grainy(given, FixedPattern(rms=size))))[1]
    assert step.effect.name == "fixed_pattern"
    assert step.effect.rms == pytest.approx(size, rel=0.05)


@pytest.mark.parametrize("principle", ["itof", "structured_light"])
@pytest.mark.parametrize("seed", range(4))
def test_noise_has_no_grain(principle, seed):
    given = sensor_of(principle)
    assert not with_grain(observe(given, grainy(given, None, seed)))[1]


def test_what_is_stated_is_not_missing():
    speckle = SpeckleNoise(sigma_px=0.05, correlation_px=5.0)
    given = replace(sensor_of("structured_light", speckle), std={("speckle_noise", "sigma_px"): 0.005})
    blocks = grainy(sensor_of("structured_light"), replace(speckle, sigma_px=0.054))
    assert not with_grain(observe(given, blocks))[1]
    (step,) = with_grain(observe(given, grainy(sensor_of("structured_light"), replace(speckle, sigma_px=0.1))))[1]
    assert step.corrected and step.effect.sigma_px == pytest.approx(0.1, rel=0.08)


@pytest.mark.parametrize(
    ("principle", "effect"), [("structured_light", PixelLocking(amplitude=0.05)), ("itof", LensDistortion(k1=0.05))]
)
def test_a_law_of_the_mean_is_no_grain(principle, effect):
    given = sensor_of(principle)
    assert not with_grain(observe(given, grainy(given, effect)))[1]


@pytest.mark.parametrize("wave_px", [20, 26, 40])
def test_a_wave_of_the_image_is_no_grain(wave_px):
    """Neighbours share what a wave leaves in a square, as far as no pattern of pixels lets them."""
    given = sensor_of("itof")
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    wave = 0.003 * np.sin(2 * np.pi * np.hypot(u - 55, v - 39) / wave_px)
    blocks = [
        replace(block, mean=block.mean + wave, held=replace(block.held, mean=block.held.mean + wave))
        for block in grainy(given, None)
    ]
    assert not with_grain(observe(given, blocks))[1]


def test_frames_that_never_change_have_no_grain():
    """Without any noise a share of it is no number."""
    coarse = Sensor("coarse", "structured_light", (DepthQuantization(step_px=0.25),))
    blocks = [
        replace(block, std=0 * block.std, mean=block.held.mean, held=replace(block.held, std=0 * block.std))
        for block in grainy(coarse, None)
    ]
    assert not with_grain(observe(coarse, blocks))[1]


def test_steps_that_no_noise_hides_are_no_grain():
    """Where all frames round to one value, what is left of it stays as speckle does."""
    coarse = Sensor(
        "coarse", "structured_light", (*sensor_of("structured_light").effects, DepthQuantization(step_px=0.25))
    )
    blocks = grainy(coarse, None)
    assert not with_grain(observe(coarse, blocks))[1]


def test_a_square_takes_its_mean_and_its_slopes_out_of_what_a_window_makes():
    for window in (1.0, 4.0, 6.0):
        fields = np.array([windowed(np.random.default_rng(k), (16, 16), window) for k in range(600)])
        v, u = np.mgrid[0:16, 0:16] - 7.5
        basis = np.stack([np.ones((16, 16)) / 16, u / np.linalg.norm(u), v / np.linalg.norm(v)]).reshape(3, -1)
        left = fields.reshape(600, -1) - fields.reshape(600, -1) @ basis.T @ basis
        left = left.reshape(fields.shape)
        apart = [np.mean(left[:, k:] * left[:, : 16 - k]) for k in APART_PX]
        assert apart == pytest.approx(_as_seen(window, 16), abs=0.02)


def test_speckle_that_nobody_stated_leaves_nothing_unexplained():
    given = sensor_of("structured_light")
    found = explained_looks(grainy(given, SpeckleNoise(sigma_px=0.05, correlation_px=5.0)), given)
    assert not found.named.steps and not found.unknown
    # squares with an edge of print in them hold fewer pixels than the covariance takes speckle to be averaged over
    assert float(found.white @ found.white) / len(found.white) < 1.5
    assert [step.effect.name for step in found.channels.steps if step.established] == ["speckle_noise"]
