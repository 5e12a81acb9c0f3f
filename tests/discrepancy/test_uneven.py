"""A size that differs over the data is no better known than it differs; one that does not costs nothing."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_walls import looks_at, sensor_of

from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.naming.effect_part import EffectPart
from fusion.discrepancy.naming.heterogeneity import unevenness
from fusion.discrepancy.naming.intervals import spreads_of
from fusion.discrepancy.naming.refit import refitted
from fusion.discrepancy.naming.search.candidates import candidate_of
from fusion.discrepancy.observe.observations import observe
from fusion.sensor.effects.phase.amplitude_error import AmplitudeError
from fusion.sensor.forms import Form

SIZE = -0.0004  # [m] at the reference: so small that what the poses do to the brightness is not seen


LAW = AmplitudeError(coefficient=SIZE)


def fit_to(growth, seed):
    """The plain law, fitted to one whose size grows from the left border to the right by a share of it."""
    blocks = []
    for block in looks_at(sensor_of("itof", LAW), seed):
        across = block.view.u / block.view.camera.width - 0.5
        blocks.append(replace(block, mean=block.mean + growth * across * LAW.bias(block.view.depth, block.view)))
    seen = observe(sensor_of("itof"), blocks)
    covariance = covariance_of(seen)
    candidate = candidate_of(seen, covariance, Form(AmplitudeError, {}, ({"coefficient": 0.001},)))
    return refitted([EffectPart(candidate, np.ones(1))], seen, covariance)


def test_a_size_that_grows_over_the_image_is_known_no_better():
    fit = fit_to(0.4, 1)
    # a slope of 0.4 over the width spreads by 0.4 / sqrt(12), less at the borders of fewer tiles
    assert unevenness(fit, 0) == pytest.approx(0.4 / np.sqrt(12), rel=0.25)
    assert spreads_of(fit)[0] > unevenness(fit, 0) * abs(fit.parts[0].weights[0])


def test_the_right_law_is_even():
    # chance alone tells one in twenty of them apart: two of eight is seen once in twenty runs
    assert sum(unevenness(fit_to(0.0, seed), 0) > 0 for seed in range(8)) <= 1
