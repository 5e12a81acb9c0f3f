"""Noise that frames share with those before them."""

import numpy as np
import pytest

from fusion.calibration.noise.memory import memory_of
from fusion.calibration.noise.repeats import repeats_of

PIXELS = 240


def filtered(frames: int, kept: float, seed: int = 0) -> np.ndarray:
    """(frames, PIXELS) of variance 1: each frame keeps a share of the one before, as with a temporal filter."""
    rng = np.random.default_rng(seed)
    values = rng.standard_normal((frames, PIXELS))
    for now, before in zip(values[1:], values, strict=False):
        now *= np.sqrt(1 - kept**2)
        now += kept * before
    return values


@pytest.mark.parametrize("kept", [0.0, 0.7, 0.9, 0.96])
def test_a_filter_does_not_make_the_noise_smaller(kept):
    found = [repeats_of(filtered(32, kept, seed)) for seed in range(8)]
    off = np.array([one.sigma - 1 for one in found])
    assert abs(off.mean()) < 0.06
    assert np.abs(off / [one.sigma_std for one in found]).max() < 5
    if kept > 0.8:  # what the scatter about the mean says
        assert np.std(filtered(32, kept), axis=0, ddof=1).mean() < 0.8


def test_what_all_pixels_share_is_no_filter_of_theirs():
    steady = filtered(32, 0) + np.linspace(0, 3, 32)[:, None]
    assert memory_of(steady).gain == 1
    assert memory_of(np.full((32, PIXELS), 1.0)).gain == 1
    assert memory_of(filtered(6, 0.9)).gain == 1  # too few frames to tell


def test_holes_are_left_out():
    found = []
    for seed in range(6):
        values = filtered(32, 0.9, seed)
        values[np.random.default_rng(seed).random(values.shape) < 0.3] = np.nan
        found.append(memory_of(values).gain * np.nanvar(values, axis=0, ddof=1).mean())
    assert np.mean(found) == pytest.approx(1, abs=0.1)
