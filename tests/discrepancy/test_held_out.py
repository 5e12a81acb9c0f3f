"""Frames that took no part in a fit must show a fair share of what it found."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_walls import looks_at, sensor_of

from fusion.discrepancy.held_out import held_out_of
from fusion.discrepancy.mean import _due
from fusion.sensor.effects.readout.depth_scale import DepthScale
from fusion.sensor.where import Bound


@pytest.mark.parametrize("share", [0.0, 0.15, 1.0])
def test_a_model_that_held_out_frames_hardly_confirm_is_contradicted(share):
    given, better = sensor_of("itof"), sensor_of("itof", DepthScale(scale=0.01))
    true = sensor_of("itof", DepthScale(scale=0.01 * share))
    blocks = [replace(block, held=held) for block, held in zip(looks_at(better, 3), looks_at(true, 4), strict=True)]
    held = held_out_of(blocks, given)
    assert held.share == 1.0  # as many frames as the others
    # what the fit gained, from frames that show all of it
    whole = held_out_of([replace(block, held=block) for block in blocks], given)
    gain = len(whole.observations.residual) * (whole.misfit(given)[0] - whole.misfit(better)[0])
    assert gain > 100
    assert held.contradicts(better, gain) == (share < 0.4)
    assert not whole.contradicts(better, gain)


@pytest.mark.parametrize(("where", "due"), [((), 300.0), ((Bound("temperature", 33.0),), 0.0)])
def test_of_a_region_frames_between_looks_need_not_show_a_share(where, due):
    """Its edge lies anywhere between two blocks, and held-out frames between them with it."""
    step = SimpleNamespace(candidate=SimpleNamespace(where=where))
    named = SimpleNamespace(steps=(step,), white=np.full(100, 1.0))
    assert _due(named, np.full(100, 2.0)) == due
