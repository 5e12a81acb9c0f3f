"""Single pixels that are stuck take no part and are told of; a pattern that all pixels have is none of them."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_walls import HEIGHT, WIDTH, looks_at, sensor_of
from test_grain import grainy

from fusion.discrepancy.explain import explained_looks
from fusion.discrepancy.observe.single_pixels import SinglePixel, single_pixels
from fusion.sensor.effects.readout.depth_quantization import DepthQuantization
from fusion.sensor.effects.readout.fixed_pattern import FixedPattern
from fusion.sensor.effects.triangulation.speckle_noise import SpeckleNoise
from fusion.sensor.sensor import Sensor

STUCK = {(40, 44): 0.9, (40, 45): 2.1, (60, 100): 2.4, (0, 0): 1.4, (79, 20): 0.3}  # (row, column): depth [m]


def stuck(blocks):
    """Blocks with pixels that always say the same."""

    def one(block):
        mean, std = block.mean.copy(), block.std.copy()
        for at, depth in STUCK.items():
            mean[at], std[at] = depth, 0.0
        return replace(block, mean=mean, std=std, held=None if block.held is None else one(block.held))

    return [one(block) for block in blocks]


@pytest.mark.parametrize("principle", ["itof", "structured_light"])
@pytest.mark.parametrize("effect", [None, FixedPattern(rms=0.004)])
def test_stuck_pixels_are_found_all_and_alone(principle, effect):
    found = single_pixels(stuck(grainy(sensor_of(principle), effect)))
    assert {(pixel.v, pixel.u) for pixel in found} == set(STUCK)


@pytest.mark.parametrize(
    ("principle", "effect"),
    [
        ("itof", None),
        ("itof", FixedPattern(rms=0.01)),
        ("structured_light", FixedPattern(rms=0.01)),
        ("structured_light", SpeckleNoise(sigma_px=0.2, correlation_px=3.0)),
    ],
)
@pytest.mark.parametrize("seed", range(4))
def test_what_all_pixels_have_is_of_no_single_one(principle, effect, seed):
    assert not single_pixels(grainy(sensor_of(principle), effect, seed))


def test_steps_of_rounding_are_no_pixels():
    coarse = Sensor("coarse", "structured_light", (DepthQuantization(step_px=0.25),))
    assert not single_pixels(grainy(coarse, None))


def test_single_frames_tell_by_their_neighbours():
    blocks = [replace(block, std=np.full_like(block.std, np.nan)) for block in looks_at(sensor_of("itof"), 1)]
    assert not single_pixels(blocks)
    assert len(single_pixels([replace(block, std=np.full_like(block.std, np.nan)) for block in stuck(blocks)])) == 5


def test_a_spot_that_is_wrong_is_a_law_and_one_placement_tells_of_no_pixel():
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    spot = 0.05 * np.exp(-((u - 40) ** 2 + (v - 30) ** 2) / 50)
    blocks = looks_at(sensor_of("itof"), 1)
    assert not single_pixels([replace(block, mean=block.mean + spot) for block in blocks])
    assert not single_pixels(stuck(blocks[:1]))


def test_stuck_pixels_are_no_pattern():
    found = explained_looks(stuck(looks_at(sensor_of("itof"), 1)), sensor_of("itof"))
    assert not found.named.steps and not found.named.likely and not found.channels.steps and not found.unknown
    assert SinglePixel(u=100, v=60) in found.alone and len(found.alone) == len(STUCK)


def test_a_pattern_keeps_its_name_and_size_beside_stuck_pixels():
    given = sensor_of("itof")
    found = explained_looks(stuck(grainy(given, FixedPattern(rms=0.002))), given)
    steps = {step.effect.name: step.effect for step in found.channels.steps if step.established}
    assert steps["fixed_pattern"].rms == pytest.approx(0.002, rel=0.05)
