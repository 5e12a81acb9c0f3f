"""A law that had to be bent to the end of its range is no explanation, whatever kind of number ended there."""

import numpy as np
import pytest

from fusion.discrepancy.naming.effect_part import EffectPart
from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.sensor.effects.phase.cyclic_error import CyclicError
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.forms import Form


def part(kind, weights, fixed=None) -> EffectPart:
    """A part whose single atoms are a millimetre high."""
    name = "amplitude" if kind is CyclicError else "offset"
    form = Form(kind, fixed or {}, ({name: 0.001},))
    return EffectPart(Candidate(form, np.zeros((1, 1)), np.zeros((1, 1))), np.array(weights, float))


@pytest.mark.parametrize(
    ("kind", "weight", "fixed", "bent"),
    [
        (DepthOffset, 10.0, {}, False),
        (DepthOffset, 1000.0, {}, True),  # 1 m, where half of that is the end
        (CyclicError, 10.0, {"period": 2.0}, False),
        (CyclicError, 300.0, {"period": 2.0}, True),  # a list parameter: one amplitude per harmonic
        (CyclicError, 10.0, {"period": 50.0}, True),  # a searched shape
    ],
)
def test_a_number_at_the_end_of_its_range_is_seen(kind, weight, fixed, bent):
    assert part(kind, [weight], fixed).at_bound(None) == bent
