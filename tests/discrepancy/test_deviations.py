"""How well a number of a named effect is known, from the weights that were fitted for it."""

from types import SimpleNamespace

import pytest

from fusion.discrepancy.naming.deviations import deviation_of
from fusion.sensor.effects.readout.fixed_pattern import FixedPattern
from fusion.sensor.parameter import parameters


def step(atoms, weights_std):
    form = SimpleNamespace(atoms=atoms)
    return SimpleNamespace(shapes_std={}, candidate=SimpleNamespace(form=form), weights_std=weights_std, std=0.1)


NAME = next(iter(parameters(FixedPattern)))


def test_a_number_is_known_as_well_as_the_weight_that_scales_it():
    about = SimpleNamespace(name=NAME)
    assert deviation_of(about, step(({NAME: 2.0},), [0.05])) == pytest.approx(0.1)


def test_the_weights_of_a_map_tell_of_no_parameter():
    """A map has a weight for every place of the image: `fusion explain` ended with an error on such a claim."""
    assert deviation_of(SimpleNamespace(name=NAME), step(({NAME: 2.0},), [0.05] * 7)) is None
