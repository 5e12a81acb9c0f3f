"""The proposed recording parts the look-alikes for which it is proposed: planned, then made, then explained."""

from functools import cache

import numpy as np
import pytest
from made_up_walls import look_at, looks_at, sensor_of

from fusion.discrepancy.inference.identifiability import visibilities
from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.naming.search.candidates import candidates_of
from fusion.discrepancy.observe.observations import observe
from fusion.discrepancy.planning.menu import MENU
from fusion.discrepancy.planning.plan import Plans, rivals_of
from fusion.discrepancy.planning.separation import Claimed, Parting, best
from fusion.sensor.effects.phase.amplitude_error import AmplitudeError
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.effects.readout.temperature_drift import TemperatureDrift

# frontal walls recorded from near to far, as the camera warms up
ORDERED = [(0.7 + 0.25 * k, 0.0, 0.0) for k in range(8)]


@cache
def known(principle):
    """The menu, observations of walls in their order, their covariance, and all candidates."""
    sensor = sensor_of(principle)
    blocks = [look_at(sensor, place, wall, 1) for place, wall in enumerate(ORDERED)]
    observations = observe(sensor, blocks)
    covariance = covariance_of(observations)
    return Plans(sensor, blocks), observations, covariance, candidates_of(observations, covariance)


def test_time_and_distance_that_went_together_are_parted_by_warming_up_alone():
    """Drift with the time since switching on looks like an offset in walls whose order is their distance."""
    plans, observations, covariance, candidates = known("structured_light")
    drift = TemperatureDrift(coefficient_px=0.01)
    white = covariance.whiten(observations.columns([drift])[:, 0])
    found = plans.to_part(Claimed(drift, white), rivals_of(["disparity_offset"], candidates))
    assert found.proposal is not None and found.proposal.choice.name == "time" and found.proposal.choice.switch
    assert found.parted == ("disparity_offset",) and found.proposal.sigma > 5


@pytest.mark.slow
def test_brightness_is_parted_from_distance_by_what_changes_the_light():
    plans, observations, covariance, candidates = known("itof")
    effect = AmplitudeError(coefficient=0.002, exponent=1.0)
    white = covariance.whiten(observations.columns([effect])[:, 0])
    found = plans.to_part(Claimed(effect, white), rivals_of(["depth_scale"], candidates))
    assert found.proposal is not None and found.proposal.choice.name in ("light", "patches", "card")


def test_an_offset_is_parted_from_a_path_inside_all_materials_by_a_sheet_of_paper():
    """On a wall of which nobody said what it is made of they are one formula."""
    plans, observations, covariance, candidates = known("itof")
    offset = DepthOffset(offset=0.002)
    white = covariance.whiten(observations.columns([offset])[:, 0])
    found = plans.to_part(Claimed(offset, white), rivals_of(["subsurface_scattering"], candidates))
    assert found.proposal is not None and found.proposal.choice.name == "slab" and found.proposal.choice.switch
    assert found.parted == ("subsurface_scattering",) and found.proposal.sigma > 5


def test_what_does_not_show_here_is_given_a_recording_that_shows_it():
    sensor = sensor_of("itof")
    blocks = looks_at(sensor, 0)
    observations = observe(sensor, blocks)
    covariance = covariance_of(observations)
    seen = {
        entry.effect for entry in visibilities(candidates_of(observations, covariance), covariance) if entry.visible
    }
    assert "multipath" not in seen  # single walls send no light to each other
    shows = {entry.effect: entry for entry in known("itof")[0].to_show(["multipath", "mixed_pixels"])}
    assert shows["multipath"].recording == "cloth" and shows["multipath"].sigma > 5
    assert shows["mixed_pixels"].sigma is None and "edge" in shows["mixed_pixels"].text


@pytest.mark.parametrize(
    ("sigmas", "chosen"),
    [
        ({"time": (30.0, 0.8), "rail": (40.0, 0.7)}, "time"),  # parts as well: poses cannot be to blame
        ({"card": (9.0, 0.99), "patches": (9.0, 0.8)}, "patches"),  # many sigma, and still alike
        ({"card": (0.2, 0.99), "patches": (0.5, 0.95)}, None),
    ],
)
def test_switches_are_preferred_when_they_part_as_well(sigmas, chosen):
    choices = {choice.name: choice for choice in MENU}
    proposal = best([(choices[name], Parting(*numbers)) for name, numbers in sigmas.items()])
    assert (proposal and proposal.choice.name) == chosen


def test_every_recording_of_the_menu_can_be_seen():
    plans = known("structured_light")[0].all
    assert len(plans) == len(MENU)
    assert all(np.isfinite(plan.observations.residual).all() for plan in plans)


def test_whichever_of_three_is_true_the_proposal_parts_them():
    """An offset, a scale and a drift of the disparity: what parts the drift alone would leave the other two."""
    plans, observations, covariance, candidates = known("structured_light")
    drift = TemperatureDrift(coefficient_px=0.01)
    white = covariance.whiten(observations.columns([drift])[:, 0])
    rivals = rivals_of(["disparity_offset", "depth_scale"], candidates)
    own = rivals_of(["temperature_drift"], candidates)["temperature_drift"]
    found = plans.to_part(Claimed(drift, white), rivals, own)
    assert found.proposal is not None and found.proposal.sigma > 5
    assert found.proposal.choice.name in ("step", "rail", "warm rail", "distance", "time")
