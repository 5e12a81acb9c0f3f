"""How good each pixel is, against plain formulas: what was made fast says the same as what is written in the papers."""

from dataclasses import replace
from math import erfc, sqrt

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.sensor.correction.estimate import jumps_along
from fusion.sensor.effect import Effect
from fusion.sensor.effects.readout.axial_noise import STEEPEST, AxialNoise
from fusion.sensor.effects.readout.lateral_noise import JUMP, LateralNoise, jump
from fusion.sensor.effects.readout.temporal_filtering import TemporalFiltering
from fusion.sensor.presets import PRESETS, default_sensor, preset
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View
from fusion.sensor.weights.rating import DOUBT, doubtful, sigma_of, weight_of

CAMERA = Camera(48, 36, 45.0, 45.0, 23.5, 17.5)


def scene(shape=CAMERA.shape, seed=0):
    """Depth [m] of a slope with steps of many heights, some just at the limit, with noise and holes."""
    rng = np.random.default_rng(seed)
    depth = np.add.outer(np.linspace(0.8, 1.4, shape[0]), np.linspace(0.0, 0.5, shape[1]))
    depth *= 1 + JUMP * rng.choice([0, 1, 2, 5], depth.shape, p=[0.7, 0.1, 0.1, 0.1])
    depth[rng.random(shape) < 0.1] = np.nan
    return depth.astype(np.float32)


def incidence(depth):
    """Angles [rad] up to edge-on, unknown here and there."""
    angle = np.random.default_rng(1).uniform(0, np.pi / 2, depth.shape)
    return np.where(np.arange(depth.size).reshape(depth.shape) % 7, angle, np.nan).astype(np.float32)


def plain_jump(depth):
    """As `jump`, pixel by pixel."""
    out = np.zeros_like(depth)
    for v, u in np.ndindex(depth.shape):
        for a, b in ((v - 1, u), (v + 1, u), (v, u - 1), (v, u + 1)):
            if 0 <= a < depth.shape[0] and 0 <= b < depth.shape[1]:
                change = depth[a, b] - depth[v, u]
                if abs(change) > JUMP * depth[v, u] and abs(change) > abs(out[v, u]):
                    out[v, u] = change
    return np.where(np.isnan(depth), depth, out)


def plain_sigma(lateral, axial, depth, tilt):
    """Nguyen, Izadi and Lovell 2012 in double precision."""
    z, theta = depth.astype(float), np.minimum(np.where(np.isnan(tilt), 0, tilt).astype(float), STEEPEST)
    step = plain_jump(depth).astype(float)
    # the jitter of an edge half a pixel away: the other surface in a share of the frames
    share = 0.5 * erfc(0.5 / lateral.sigma_px / sqrt(2))
    along = axial.c0 + axial.c1 * z + axial.c2 * z**2
    along += axial.angle * z**axial.angle_exponent * (theta / (np.pi / 2 - theta)) ** 2
    return np.hypot(np.abs(step) * np.sqrt(share * (1 - share)), along)


@pytest.mark.parametrize("shape", [CAMERA.shape, (5, 1), (1, 5), (1, 1)])
def test_steps_to_neighbours_are_those_of_each_pixel(shape):
    for seed in range(3):
        depth = scene(shape, seed)
        assert np.array_equal(jump(depth), plain_jump(depth), equal_nan=True)
        assert np.array_equal(jump(np.asfortranarray(depth)), plain_jump(depth), equal_nan=True)


@pytest.mark.parametrize("shape", [CAMERA.shape, (5, 1), (1, 5), (1, 1)])
@pytest.mark.parametrize("axis", [0, 1])
def test_edges_of_a_measured_image_are_those_of_whole_images(shape, axis):
    for seed in range(3):
        depth = scene(shape, seed)
        z = depth if axis == 1 else depth.T
        # pairs of pixels, and the flatter of two pairs on each side
        change = np.abs(np.diff(1 / z, axis=1))
        beside = np.pad(np.nan_to_num(change), ((0, 0), (2, 2)))
        slope = np.maximum(np.minimum(beside[:, :-4], beside[:, 1:-3]), np.minimum(beside[:, 3:-1], beside[:, 4:]))
        edge = (change > JUMP / np.fmin(z[:, 1:], z[:, :-1])) & (slope < change / 2)
        line, place = np.nonzero(edge | (np.isnan(z[:, 1:]) != np.isnan(z[:, :-1])))
        first, step = (line * shape[1] + place, 1) if axis == 1 else (place * shape[1] + line, shape[1])
        found = jumps_along(depth, axis)
        assert np.array_equal(found[0], first) and np.array_equal(found[1], first + step)


@pytest.mark.parametrize("exponent", [-0.5, 0.0, 0.3, 1.0, 1.5, 2.0])
def test_sigma_and_weight_are_those_of_the_paper(exponent):
    lateral, axial = default_sensor(CAMERA).effects
    assert isinstance(lateral, LateralNoise) and isinstance(axial, AxialNoise)
    axial = replace(axial, angle_exponent=exponent)
    depth = scene()
    tilt = incidence(depth)
    sensor = Sensor(effects=(lateral, axial))
    for angle in (None, tilt):
        view = View(CAMERA, depth, angle)
        expected = plain_sigma(lateral, axial, depth, np.zeros_like(depth) if angle is None else angle)
        sigma, weight = sigma_of(sensor, view), weight_of(sensor, view)
        # 1e-4: between the float32 angle and the pole of its term at 90 deg lie 8 deg, which adds some 10 roundings;
        # the table of normal shares is exact to 1e-6
        assert np.allclose(sigma, expected, rtol=1e-4, atol=0, equal_nan=True)
        assert np.allclose(weight, np.nan_to_num(expected**-2.0), rtol=2e-4, atol=0)
        assert sigma.dtype == weight.dtype == np.float32


@pytest.mark.parametrize("name", PRESETS)
def test_every_effect_adds_its_noise_as_if_it_were_alone(name):
    sensor = preset(name)
    depth = scene()
    view = View(CAMERA, depth, incidence(depth), ir=1000 / depth**2)
    seen = sensor.seen(view)
    variance, kept = 0 * depth.astype(float), np.ones(depth.shape)
    with np.errstate(all="ignore"):
        for effect in sensor.effects:
            variance = variance + np.asarray(effect.noise(depth, seen), float) ** 2
            kept = kept * (1 - np.asarray(effect.dropout(depth, seen), float))
    assert np.allclose(sigma_of(sensor, view), np.sqrt(variance), rtol=1e-5, atol=0, equal_nan=True)
    trust = np.where(doubtful(sensor, depth, seen.time_of_flight), DOUBT, 1.0)
    # a dropout near 1 leaves a difference of numbers that are rounded to 1e-7
    assert np.allclose(weight_of(sensor, view), np.nan_to_num(trust * kept / variance), rtol=1e-4, atol=1e-1)


def test_edges_join_other_noise_as_any_effect_does():
    depth = scene()
    view, before = View(CAMERA, depth), np.full(depth.shape, np.float32(0.01))
    before[3] = np.nan
    for effect in (
        LateralNoise(sigma_px=0.8),
        LateralNoise(sigma_px=np.full(depth.shape, 0.5), sigma=0.001),
        LateralNoise(),
    ):
        joined = effect.spread(before, depth, view)
        # rounding alone: the same sum, in another order
        assert np.allclose(joined, Effect.spread(effect, before, depth, view), rtol=1e-6, equal_nan=True)
    assert (before[0] == np.float32(0.01)).all()  # what was given stays as it was


def test_what_is_filtered_keeps_its_place_in_the_chain():
    depth = scene()
    sensor = Sensor(effects=(AxialNoise(c0=0.002), TemporalFiltering(memory=0.6)))
    assert np.nanmax(sigma_of(sensor, View(CAMERA, depth))) == pytest.approx(0.002 * sqrt(0.4 / 1.6), rel=1e-5)
