"""A law of a part of the data must leave noise, which is as large as its grain may be where nothing else is left."""

from types import SimpleNamespace

import numpy as np
import pytest

from fusion.discrepancy.inference.loose import Loose
from fusion.discrepancy.mean import MeanFindings
from fusion.sensor.effects.triangulation.speckle_noise import SpeckleNoise
from fusion.sensor.sensor import Sensor
from fusion.sensor.where import Bound

SPECKLE = SpeckleNoise(sigma_px=0.02, correlation_px=5.0)
STATED = {("speckle_noise", "sigma_px"): 0.003, ("speckle_noise", "correlation_px"): 1.0}  # 30 and 40 % of a variance


@pytest.mark.parametrize(
    ("chi2", "std", "left", "foreseen"),
    [
        (1.25, {}, 5.0, True),
        (1.6, {}, 0.0, False),  # size and window of the grain are exact
        (1.6, STATED, 0.0, True),
        (1.6, STATED, 5.0, False),  # something follows a variable
        (2.6, STATED, 0.0, False),  # 1.3 times 1.8 is what noise may be
    ],
)
def test_a_part_leaves_noise_as_large_as_its_grain_may_be(chi2, std, left, foreseen):
    sensor = Sensor("made up", "structured_light", (SPECKLE,), std=std)
    step = SimpleNamespace(candidate=SimpleNamespace(where=(Bound("depth", 2.0),)))
    seen = SimpleNamespace(observations=SimpleNamespace(loose=Loose()), white=np.full(50, 9.0))
    named = SimpleNamespace(white=np.full(50, chi2**0.5), steps=(step,), sensor=sensor)
    assert MeanFindings(seen, named, None, None, SimpleNamespace(gain=left), None).foresees == foreseen
