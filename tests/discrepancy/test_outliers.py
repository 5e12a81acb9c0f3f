"""Things before the wall take no part, and are told of; what the sensor does to the whole image is none of them."""

from dataclasses import replace

import numpy as np
from made_up_walls import looks_at, sensor_of

from fusion.discrepancy.observe.observations import observe
from fusion.discrepancy.observe.outliers import RIM_PX, foreign
from fusion.sensor.effects.readout.depth_scale import DepthScale


def wall(noise=0.003):
    depth = np.tile(np.linspace(1.5, 2.5, 120), (90, 1))
    return depth, depth + np.random.default_rng(1).normal(0, noise, depth.shape)


def test_a_thing_before_the_wall_is_foreign_with_its_rim():
    depth, measured = wall()
    measured[30:50, 40:70] -= 0.35
    found = foreign(measured, depth)
    assert found[30:50, 40:70].all()
    inside = np.zeros_like(found)
    inside[30 - RIM_PX - 1 : 50 + RIM_PX + 1, 40 - RIM_PX - 1 : 70 + RIM_PX + 1] = True
    assert not found[~inside].any()


def test_errors_of_a_sensor_are_not_foreign():
    depth, measured = wall()
    assert not foreign(measured, depth).any()
    assert not foreign(1.1 * measured, depth).any()  # a wrong unit or law is off everywhere
    assert not foreign(measured + 0.2, depth).any()
    lost = measured.copy()
    lost[20:60] = np.nan
    assert not foreign(lost, depth).any()
    flying = measured.copy()
    flying[::7, ::5] -= 0.5  # single pixels are noise of another kind
    assert not foreign(flying, depth).any()
    assert not foreign(np.full_like(depth, np.nan), depth).any()


def test_tiles_of_a_thing_are_left_out():
    blocks = looks_at(sensor_of("itof", DepthScale(scale=0.02)), 1)
    covered = blocks[3].mean.copy()
    covered[20:44, 30:62] -= 0.35
    before = observe(sensor_of("itof"), blocks)
    after = observe(sensor_of("itof"), [*blocks[:3], replace(blocks[3], mean=covered), *blocks[4:]])
    assert 0 < len(before.residual) - len(after.residual) < 20
    assert np.abs(after.residual).max() < 0.1
