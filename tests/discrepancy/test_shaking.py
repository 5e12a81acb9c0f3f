"""Frames of a camera that shakes: the size of the shakes is found, and taken out of what pixels scatter."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_walls import WALLS, look_at, sensor_of

from fusion.discrepancy.explain import explained_looks
from fusion.discrepancy.inference.shaking import shaking_of, steadied
from fusion.discrepancy.observe.frame_block import TileCourse
from fusion.discrepancy.observe.frames import FrameSeries
from fusion.discrepancy.observe.interior import interior
from fusion.discrepancy.observe.tiles import tiling
from fusion.geometry.pose import exp
from fusion.sensor.laws.surface import seen_along

FRAMES = 6
SHIFT_M, TURN = 0.002, 0.0015


def shaken(seed, place, wall, shift=SHIFT_M, turn=TURN, offset=0.0):
    """A wall, each frame from a place of its own and longer by an offset of its own."""
    sensor = sensor_of("itof")
    still = look_at(sensor, place, wall, seed)
    rng = np.random.default_rng([seed, place, 7])
    tiles = tiling(interior(still.view) & np.isfinite(still.view.depth))
    series = FrameSeries(still.view.camera.shape, tiles)
    rays = still.view.camera.rays()
    for _ in range(FRAMES):
        T = exp(rng.standard_normal(6) * np.repeat([turn, shift], 3))
        depth = seen_along(still.view.depth, rays, still.view, T) + offset * rng.standard_normal()
        series.add(sensor.sample(depth, still.view, None, rng))
    pixels = series.pixels
    course = TileCourse(tiles, series.course, series.seen)
    return replace(
        still, mean=pixels.mean, std=pixels.std, count=pixels.count, succession=series.succession, alike=series.alike,
        frames=tuple(range(FRAMES)), course=course,
    )  # fmt: skip


def series(seed, **how):
    return [shaken(seed, place, wall, **how) for place, wall in enumerate(WALLS)]


def test_the_size_of_shakes_is_found():
    found = shaking_of(series(1))
    # eight walls of six frames: 40 draws of each number, of which a wall shows three
    assert found.sigma_m == pytest.approx(SHIFT_M, rel=0.35)
    assert found.sigma_rad == pytest.approx(TURN, rel=0.35)
    assert 0 < found.std_m < 0.5 * SHIFT_M
    assert found.share > 0.9


@pytest.mark.parametrize("seed", range(5))
def test_a_camera_that_stands_still_does_not_shake(seed):
    assert shaking_of(series(seed, shift=0.0, turn=0.0)) is None


def test_an_offset_of_whole_frames_is_no_shaking():
    assert shaking_of(series(2, shift=0.0, turn=0.0, offset=0.002)) is None


def test_what_is_steadied_scatters_by_its_noise_alone():
    blocks = series(3)
    steady = steadied(blocks, shaking_of(blocks))
    before, after = (np.sqrt(np.mean([np.nanmean(k.std**2) for k in some])) for some in (blocks, steady))
    assert before > 1.3 * 0.002
    assert after == pytest.approx(0.002, rel=0.1)
    assert np.abs(steady[0].alike[:, 1:]).max() < 0.1 < blocks[0].alike[:, 1:].max()


@pytest.mark.slow
def test_shaking_is_claimed_and_nothing_else():
    found = explained_looks(series(4), sensor_of("itof"))
    assert [step.effect.name for step in found.channels.steps] == ["pose_jitter"]
    assert not found.named.steps and not found.unknown
    assert found.sensor.effect("pose_jitter").sigma_m == pytest.approx(SHIFT_M, rel=0.4)
