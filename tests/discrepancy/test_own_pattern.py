"""A unit differs from others by its own pattern, of which a preset knows the usual size: nothing is missing then."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_walls import looks_at, sensor_of

from fusion.discrepancy.explain import explained_looks
from fusion.discrepancy.inference.own_pattern import own_patterns
from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.observe.observations import observe
from fusion.sensor.effects.readout.fixed_pattern import FixedPattern
from fusion.sensor.effects.triangulation.disparity_distortion import DisparityDistortion
from fusion.sensor.effects.triangulation.vertical_banding import VerticalBanding

PATTERNS = [
    ("structured_light", VerticalBanding(step=0.06)),
    ("structured_light", DisparityDistortion(rms=0.02)),
    ("itof", FixedPattern(rms=0.02)),
]


def of_unit(principle, pattern, unit, seed=1):
    """Walls as one unit sees them, and the model of all units."""
    given = sensor_of(principle, pattern)
    blocks = []
    for block in looks_at(sensor_of(principle), seed):
        view = replace(block.view, moment=replace(block.view.moment, unit=unit))
        blocks.append(replace(block, mean=block.mean + pattern.bias(block.view.depth, view)))
    return blocks, given


@pytest.mark.parametrize(("principle", "pattern"), PATTERNS)
def test_residuals_of_any_unit_are_as_large_as_its_pattern_may_be(principle, pattern):
    calm = []
    for unit in range(4):
        blocks, given = of_unit(principle, pattern, unit, seed=unit)
        observations = observe(given, blocks)
        white = covariance_of(observations).whiten(observations.residual)
        calm.append(float(white @ white) / len(white))
    assert 0.6 < np.mean(calm) < 1.3, calm


def test_what_a_unit_is_known_to_have_is_no_pattern():
    bands = VerticalBanding(columns=[20.0, 60.0], steps=[0.1, -0.1])
    blocks, given = of_unit("structured_light", bands, 1)
    assert not np.any(own_patterns(observe(given, blocks)))


@pytest.mark.slow
@pytest.mark.parametrize(("principle", "pattern"), PATTERNS)
def test_the_own_pattern_of_a_unit_is_no_law(principle, pattern):
    blocks, given = of_unit(principle, pattern, 5)
    found = explained_looks(blocks, given)
    assert not found.named.steps and not found.unknown
