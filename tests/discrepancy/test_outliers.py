"""Things before the wall take no part, and are told of; what the sensor does to the whole image is none of them."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_walls import looks_at, sensor_of
from scipy.ndimage import binary_dilation

from fusion.discrepancy.observe.observations import observe
from fusion.discrepancy.observe.outliers import RIM_PX, Stays, foreign
from fusion.discrepancy.observe.things import _Seen
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.depth_quantization import DepthQuantization
from fusion.sensor.effects.readout.depth_scale import DepthScale
from fusion.sensor.sensor import Sensor


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


@pytest.mark.parametrize("height", [0.45, 0.75, 1.2])
def test_a_floor_is_foreign_down_to_where_it_meets_the_wall(height):
    """However much of the image it takes, as long as most of it shows the wall; near the wall it is next to nothing."""
    measured = wall()[1] + 1.0
    v = np.arange(90)[:, None] - 44.5
    floor = np.where(v > 0, height * 80 / np.maximum(v, 0.1), np.inf)
    before = measured - floor
    found = foreign(np.minimum(measured, floor), wall()[0] + 1.0)
    assert found.any() and found[before > 0.015].all()  # 0.003 m of noise
    assert not found[~binary_dilation(before > 0, iterations=RIM_PX + 1)].any()


def test_a_scale_that_is_wrong_is_no_thing_however_deep_the_image():
    depth = np.tile(np.linspace(1.0, 3.0, 120), (90, 1))
    assert not foreign(1.2 * depth, depth).any()
    assert not foreign(0.8 * depth, depth).any()


def test_far_is_told_by_what_stands_there_where_a_range_wraps():
    depth, measured = wall()
    short = depth - 1.45  # near nothing where it wraps
    measured = measured - 1.45
    measured[30:50, 2:20] += 0.03  # as a pose that is off makes at a wall seen along itself
    assert foreign(measured, short).any()
    assert not foreign(measured, short, depth).any()


def test_tiles_of_a_thing_are_left_out():
    blocks = looks_at(sensor_of("itof", DepthScale(scale=0.02)), 1)
    covered = blocks[3].mean.copy()
    covered[20:44, 30:62] -= 0.35
    before = observe(sensor_of("itof"), blocks)
    after = observe(sensor_of("itof"), [*blocks[:3], replace(blocks[3], mean=covered), *blocks[4:]])
    assert 0 < len(before.residual) - len(after.residual) < 20
    assert np.abs(after.residual).max() < 0.1


def test_who_passes_is_out_of_the_frames_and_the_wall_behind_stays():
    depth = wall()[0]
    frames = np.array([wall()[0] + np.random.default_rng(k).normal(0, 0.003, depth.shape) for k in range(7)])
    for k in range(5):  # in most of the frames somewhere, in no place in more than five of seven
        frames[k, :, 10 + 8 * k : 60 + 8 * k] = 0.5
    frames[6, 40:60, 100:] = np.nan
    stays = Stays(frames)
    assert np.abs(stays.depth - depth).max() < 0.02
    for k, frame in enumerate(frames):
        assert stays.hidden(frame).any() == (k < 5)
        left = np.where(stays.hidden(frame), np.nan, frame)
        assert np.nanmax(np.abs(left - depth)) < 0.02


def test_nothing_passes_where_values_are_lost_or_single_ones_are_far_off():
    frames = np.array([wall()[1] for _ in range(4)])
    frames[1, 20:60] = np.nan
    frames[2, ::7, ::5] -= 0.5
    stays = Stays(frames)
    assert not any(stays.hidden(frame).any() for frame in frames)


def test_noise_of_a_steep_wall_is_nobody_passing():
    depth = wall()[0]
    sigma = np.linspace(0.001, 0.12, depth.shape[1]) * depth
    frames = np.array([depth + sigma * np.random.default_rng(k).normal(size=depth.shape) for k in range(7)])
    assert not any(Stays(frames).hidden(frame).any() for frame in frames)
    frames[3, 20:50, :50] -= 0.5 * depth[20:50, :50]  # where there is less of it, somebody is still seen
    assert Stays(frames).hidden(frames[3])[25:45, 5:45].all()


def test_levels_of_a_rounding_are_no_things_and_nobody_passing():
    """Half a pixel of disparity at 3 m: 8 % of the depth, and no noise about it. Levels end as sharply as things do."""
    step = np.full((90, 120), 0.25)
    level = np.full(step.shape, 3.0)
    other = level.copy()
    other[30:70, 40:90] -= step[30:70, 40:90]
    assert foreign(other, level).any() and not foreign(other, level, least=1.5 * step).any()
    frames = np.array([level, other, level, level, level])
    assert Stays(frames).hidden(other).any() and not Stays(frames, lambda depth: 1.5 * step).hidden(other).any()
    nearer = level - 2 * (level - other)  # two steps before its ground: a thing
    assert foreign(nearer, level, least=1.5 * step).any()
    assert Stays(frames, lambda depth: 1.5 * step).hidden(nearer).any()


def test_a_thing_stands_more_than_a_step_before_its_ground():
    sensor = Sensor("made up", "structured_light", (AxialNoise(sigma_px=0.004), DepthQuantization(step_px=0.05)))
    wall, *others = looks_at(sensor, 1, off=0.0)
    native = wall.view.focal_baseline / wall.mean**2

    def pieces(steps):
        seen = wall.mean.copy()
        seen[24:50, 30:70] -= steps * 0.05 / native[24:50, 30:70]
        patches = observe(sensor, [replace(wall, mean=seen), *others]).patches
        return [int(piece.sum()) for piece in _Seen(patches[0]).pieces()]

    assert not pieces(1) and len(pieces(2)) == 1 and pieces(2)[0] > 1000
