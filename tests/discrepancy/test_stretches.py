"""Frames of one pose are one measurement as long as they do not move together slower than they follow each other."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_walls import WALLS, look_at, loose_in, sensor_of

from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.observe.observations import observe
from fusion.discrepancy.observe.stretches import stretches_of
from fusion.geometry.trajectory import Trajectory
from fusion.sensor.effects.phase.sensor_interference import SensorInterference

FRAMES, STEP_S, PERIOD_S = 100, 0.6, 10.0


def stage(course, rng, pixel_m=0.002):
    """A camera that stands still for a minute; `course` (n,) [m] is what all pixels of a frame are off."""
    frames = [SimpleNamespace(depth=1.0 + off + rng.normal(0, pixel_m, (48, 64))) for off in course]
    stamps = STEP_S * np.arange(len(course))
    recording = type("Taken", (list,), {})(frames)
    recording.timestamps, recording.poses = stamps, Trajectory(stamps, np.tile(np.eye(4), (len(course), 1, 1)))
    return SimpleNamespace(recording=recording, simulated=None)


def lengths(course, seed=0):
    """Frames of the longest stretch, and whether they are said to move."""
    found = stretches_of(stage(course, np.random.default_rng(seed)))
    assert [i for stretch in found.frames for i in stretch] == list(range(len(course)))
    return max(map(len, found.frames)), found.moving


def test_noise_that_is_new_in_every_frame_leaves_stretches_whole():
    for seed in range(5):
        rng = np.random.default_rng(seed)
        assert lengths(np.zeros(FRAMES), seed) == (17, False)
        assert lengths(rng.normal(0, 0.001, FRAMES), seed) == (17, False)  # a camera that shakes


def test_a_beat_is_cut_shorter_than_its_period():
    frames, moving = lengths(0.001 * np.sin(2 * np.pi * STEP_S * np.arange(FRAMES) / PERIOD_S))
    assert moving and (frames - 1) * STEP_S <= PERIOD_S / 3


def test_a_law_of_time_is_its_mean_over_the_frames():
    sensor, effect = sensor_of("itof"), SensorInterference(fraction=0.02)
    block = look_at(sensor, 0, WALLS[0], 0)
    times = (100.0, 102.0, 104.0, 106.0)
    (patch,) = observe(sensor, [replace(block, times=times)]).patches
    view = patch.view
    single = [effect.change(patch.depth, replace(view, moment=replace(view.moment, time=t))) for t in times]
    usual = patch.tiles.mean(np.mean(single, axis=0) * patch.native)
    np.testing.assert_allclose(patch.column(effect), usual, rtol=1e-6)
    better = patch.under(sensor.having(effect))
    np.testing.assert_allclose(patch.tiles.mean((better.predicted - patch.predicted) * patch.native), usual, rtol=0.02)


@pytest.mark.parametrize("seed", [0, 1])
def test_frames_that_wander_without_a_law_are_told_by_their_size(seed):
    rng, blocks = np.random.default_rng(seed), []
    for place in range(2):
        still, course = look_at(sensor_of("itof"), place, WALLS[place], seed), np.zeros(12)
        for k in range(1, 12):  # forgets half of itself from one to the next
            course[k] = 0.5 * course[k - 1] + rng.normal(0, 0.001)
        for k, off in enumerate(course):
            block = look_at(sensor_of("itof"), place, WALLS[place], 100 * seed + k)
            time = 300.0 * place + 3.0 * k
            view = replace(still.view, moment=replace(still.view.moment, time=time))
            mean = block.mean - block.view.depth + still.view.depth + off / view.stretch
            blocks.append(replace(still, view=view, mean=mean, times=(time, time + 1.0)))
    loose = loose_in(blocks)
    # 1.2 mm: one way of four that share a size, so twice as much, of the few numbers that laws of time leave
    assert 0.0004 < loose.wander < 0.01
    # nothing else is blown up to stand for it, whatever laws of time leave of it
    assert loose.pose < 10 and loose.drift < 0.003 and loose.bent < 0.003
    covariance_of(replace(observe(sensor_of("itof"), blocks), loose=loose))
