"""Ranges that lost whole turns of the phase are told as such, from recordings that also show where turns begin."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_walls import looks_at, sensor_of

import fusion
from fusion.discrepancy.belonging import refuse_strangers
from fusion.discrepancy.explain import explained_looks
from fusion.discrepancy.verdict.sizes import size_of_step
from fusion.discrepancy.wrapping import clear_of_turns, wrapping_of
from fusion.errors import RecordingError
from fusion.sensor.effects.phase.phase_wrapping import PhaseWrapping
from fusion.simulation.scenes.panel import wall

CAMERA = replace(fusion.find_camera("kinect-v2"), width=80, height=60, fx=56.0, fy=56.0, cx=39.5, cy=29.5)
NEAR_WALLS = [(0.8, 0, 0), (0.9, 20, 0), (1.0, -10, 15)]


@pytest.mark.parametrize("length", [1.874, 1.31])  # of a usual modulation, and of none
def test_the_length_of_a_turn_is_found_and_nothing_else(length):
    given = sensor_of("itof")
    blocks = looks_at(sensor_of("itof", PhaseWrapping(range=length)), 1)
    found = wrapping_of(blocks, given)
    assert found.step.established
    assert float(found.effect.range) == pytest.approx(length, abs=3 * found.std)
    assert found.std < 0.003
    better = found.added_to(given)
    clear = clear_of_turns(blocks, found)
    refuse_strangers(clear, better)
    told = explained_looks(clear, better, (found.step,))
    assert not told.named.steps
    assert not told.unknown
    assert [step.effect.name for step in told.channels.steps if step.established] == ["phase_wrapping"]
    assert told.sensor.effect("phase_wrapping") == found.effect
    size = size_of_step(told, found.step)
    assert size.rms_m > 0.8 * length  # where it acts; some pixels lost two turns


@pytest.mark.parametrize(
    "blocks",
    [
        looks_at(sensor_of("itof"), 2),
        looks_at(sensor_of("structured_light"), 2),
        looks_at(sensor_of("itof", PhaseWrapping(range=1.874)), 2, NEAR_WALLS),  # no pixel is that far away
    ],
)
def test_where_nothing_is_lost_nothing_wraps(blocks):
    assert wrapping_of(blocks, sensor_of(blocks[0].view.camera.principle)) is None


def test_another_scene_does_not_wrap():
    blocks = looks_at(sensor_of("itof"), 3)
    nearer = [replace(block, mean=block.mean - 0.3 - 0.2 * k) for k, block in enumerate(blocks)]
    assert wrapping_of(nearer, sensor_of("itof")) is None


def test_a_single_view_all_beyond_an_unknown_turn_is_refused_with_what_to_do(tmp_path):
    noise = sensor_of("itof")
    wraps = noise.having(PhaseWrapping(range=1.31))
    fusion.write_simulation(tmp_path / "far", fusion.simulate(replace(wall((2.0,), frames=4), camera=CAMERA), wraps, 1))
    recording = fusion.open_recording(tmp_path / "far")
    with pytest.raises(RecordingError, match=r"wraps beyond 1\.3\d m.*114.* MHz"):
        fusion.explain([recording], noise)
    told = fusion.explain([recording], wraps)  # as the line says
    assert not told.named.steps


def test_a_model_that_wraps_is_believed():
    given = sensor_of("itof", PhaseWrapping(range=1.874))
    blocks = looks_at(given, 4)
    assert wrapping_of(blocks, given) is None
    refuse_strangers(blocks, given)
    assert np.isfinite(blocks[0].mean).any()
