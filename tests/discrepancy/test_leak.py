"""A law of two variables at once, each of which an entry of the catalogue has alone, is one law and not two names."""

from types import SimpleNamespace

import numpy as np
import pytest
from made_up_walls import looks_at, sensor_of

from fusion.discrepancy.explain import explained_looks
from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.observe.observations import observe
from fusion.discrepancy.unknown.in_place import is_asked
from fusion.discrepancy.unknown.law import law_of
from fusion.discrepancy.unknown.unrestricted import explained, groups_of


def leak(view, turns):
    """[m] What a constant phasor at each of two modulations adds to the depth: the more, the less light comes back."""
    r = view.depth * view.stretch
    waves = sum(share * np.sin(2 * np.pi * r / period + turn) for share, period, turn in zip(*LEAK, turns, strict=True))
    return 0.003 * waves * 1000.0 / view.ir / view.stretch


LEAK = ((0.6, 0.4), (1.25, 1.87))  # shares, and half a wavelength of 120 and of 80 MHz [m]


def hiding_a_leak(turns):
    sensor = sensor_of("itof")
    blocks = looks_at(sensor, 11)
    for block in blocks:
        block.mean[...] = block.mean + leak(block.view, turns)
    return sensor, blocks


def test_a_wave_that_the_brightness_hides_is_found_with_it():
    before = observe(*hiding_a_leak((3.5, 0.3)))
    covariance = covariance_of(before)
    white = covariance.whiten(before.residual)
    left = explained(white, groups_of(before, covariance), np.zeros((len(white), 0)))
    law = law_of(white, before, covariance, left)
    # on a wall depth and range say the same
    assert {"range", "amplitude"} <= {name.replace("depth", "range") for name in law.variables}
    assert law.simple and law.replicated and law.gain > left.gain  # which no sum of functions of each alone reaches


@pytest.mark.slow
def test_a_wave_of_the_range_that_grows_with_the_darkness_is_one_unknown_law_of_both_and_not_two_names():
    sensor, blocks = hiding_a_leak((0.4, 2.0))
    found = explained_looks(blocks, sensor)
    assert not found.named.steps and found.unknown
    assert {"range", "amplitude"} <= {name.replace("depth", "range") for name in found.beyond.law.variables}


def test_a_formula_is_asked_for_where_names_leave_more_than_noise():
    def named(left):
        form = SimpleNamespace(columns=np.zeros((1, 1)), where=(), form=SimpleNamespace(map=""))
        step = SimpleNamespace(candidate=form, effect=SimpleNamespace(name="one"), gain=1000.0)
        return SimpleNamespace(steps=(step,), white=np.full(100, np.sqrt(left / 100)))

    # noise alone is 1 per tile; a formula must explain a fifth more than the one name
    assert not is_asked(named(150.0)) and is_asked(named(350.0))
    assert not is_asked(SimpleNamespace(steps=()))
