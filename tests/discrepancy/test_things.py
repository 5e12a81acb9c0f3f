"""A thing close to its ground is told by its outline; laws, prints and patterns are none."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_walls import HEIGHT, WIDTH, looks_at, sensor_of

from fusion.discrepancy.explain import explained_looks
from fusion.discrepancy.observe.observations import observe
from fusion.discrepancy.observe.things import things
from fusion.sensor.effects.light.stray_light import StrayLight
from fusion.sensor.effects.phase.cyclic_error import CyclicError
from fusion.sensor.effects.readout.depth_offset import DepthOffset

V, U = np.mgrid[:HEIGHT, :WIDTH]
BOOK = (np.abs(U - 50) < 14) & (np.abs(V - 45) < 10)


def off(blocks, which, changed):
    """The blocks with the mean of some of them changed: a function of the block gives by how much [m]."""
    return [replace(b, mean=b.mean + changed(b)) if k in which else b for k, b in enumerate(blocks)]


def found(blocks, principle="itof"):
    return [bool(mask.any()) for mask in things(observe(sensor_of(principle), blocks).patches)]


@pytest.mark.parametrize("principle", ["itof", "structured_light"])
def test_a_book_on_a_wall_is_told_and_left_out(principle):
    blocks = off(looks_at(sensor_of(principle), 5), (1, 2), lambda block: -0.03 * BOOK)
    assert found(blocks, principle) == [place in (1, 2) for place in range(len(blocks))]
    (mask,) = things(observe(sensor_of(principle), blocks).patches)[1:2]
    assert mask[BOOK].all() and not mask[:, 75:].any()
    left = explained_looks(blocks, sensor_of(principle))
    assert not left.named.steps and not left.named.likely and left.before.loose.drift < 1e-4


def test_an_effect_keeps_its_name_beside_a_book():
    blocks = off(looks_at(sensor_of("itof", DepthOffset(offset=0.01)), 5), (1, 4), lambda block: -0.03 * BOOK)
    (step,) = explained_looks(blocks, sensor_of("itof")).named.steps
    assert step.effect.name == "depth_offset" and step.effect.offset == pytest.approx(0.01, abs=0.001)


EVERY = range(8)
LAWS = {
    "a step of depth": (EVERY, lambda block: 0.03 * (block.view.depth > 1.6)),
    "a band of columns": (EVERY, lambda block: 0.03 * (np.abs(U - 40) < 8)),
    "a spot of the sensor": (EVERY, lambda block: 0.03 * BOOK),
    "a smooth bump": ((2, 3), lambda block: 0.03 * np.exp(-((U - 50) ** 2 + (V - 40) ** 2) / 300)),
    "what is dark": (EVERY, lambda block: 0.03 * (block.view.reflectance < 0.2)),
    "a recording that is off": ((3,), lambda block: 0.03),
}


@pytest.mark.parametrize(("which", "changed"), LAWS.values(), ids=LAWS)
def test_what_laws_do_is_no_thing(which, changed):
    assert not any(found(off(looks_at(sensor_of("itof"), 5), which, changed)))


@pytest.mark.parametrize("hidden", [CyclicError(amplitude=(0.03,), period=(0.4,)), StrayLight(fraction=0.1, width=8.0)])
def test_what_effects_do_is_no_thing(hidden):
    assert not any(found(looks_at(sensor_of("itof", hidden), 5)))
