"""Neighbours that share their noise: single frames tell it too, by what is rough in their residuals."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_walls import FRAMES, WALLS, looks_at, sensor_of
from scipy.ndimage import gaussian_filter

from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.observe.frames import REACH_PX, likeness
from fusion.discrepancy.observe.observations import observe
from fusion.sensor.effects.readout.depth_offset import DepthOffset

WIDE_PX = 0.9  # of the Gaussian that white noise went through
NOISE_M = 0.002  # of a pixel, as the model says


def single_frames(seed, *hidden):
    """Blocks of one frame each whose noise a smoothing has spread over neighbours, of the size that is stated."""
    rng, out = np.random.default_rng([seed, 9]), []
    for block in looks_at(sensor_of("itof", *hidden), seed, WALLS):
        noise = gaussian_filter(rng.standard_normal(block.mean.shape), WIDE_PX)
        # the mean of many draws as the truth: its own noise is taken out again
        clean = sensor_of("itof", *hidden).repeated(block.view.depth, block.view)[0]
        mean = clean + NOISE_M * noise / noise.std()
        out.append(replace(block, frames=(0,), mean=mean, std=np.full(mean.shape, np.nan), count=block.count // FRAMES))
    return out


@pytest.mark.parametrize("hidden", [(), (DepthOffset(offset=0.01),)])
def test_single_frames_tell_how_alike_the_noise_of_neighbours_is(hidden):
    seen = observe(sensor_of("itof"), single_frames(1, *hidden))
    apart = np.arange(1, 4)
    expected = np.exp(-(apart**2) / (4 * WIDE_PX**2))
    assert np.abs(seen.patches[0].alike[:, 1:4] - expected).max() < 0.05


def test_tiles_of_single_frames_are_as_unsure_as_they_are():
    seen = observe(sensor_of("itof"), single_frames(2))
    blind = replace(seen, patches=tuple(replace(patch, shared=None) for patch in seen.patches))
    told, untold = (float(np.mean(covariance_of(one).whiten(one.residual) ** 2)) for one in (seen, blind))
    assert 0.75 < told < 1.25
    assert untold > 2.0 * told


def test_noise_that_nobody_shares_is_as_it_was():
    blocks = single_frames(3)
    rng = np.random.default_rng(3)
    blocks = [replace(k, mean=k.view.depth + NOISE_M * rng.standard_normal(k.mean.shape)) for k in blocks]
    seen = observe(sensor_of("itof"), blocks)
    assert np.abs(seen.patches[0].alike[:, 1:]).max() < 0.03
    assert 0.75 < np.mean(covariance_of(seen).whiten(seen.residual) ** 2) < 1.25


@pytest.mark.parametrize("shape", [(4, 4), (8, 8), (6, 7), (1, 12)])
def test_images_of_few_pixels_have_no_neighbours_farther_apart(shape):
    alike = likeness(np.random.default_rng(0).standard_normal(shape))
    assert alike.shape == (2, REACH_PX + 1)
    assert not alike[0, shape[1] :].any() and not alike[1, shape[0] :].any()
