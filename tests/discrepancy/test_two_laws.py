"""A wave of which only a part is seen may be an offset with a slope; of which much is seen, not."""

import numpy as np
from made_up_walls import looks_at, sensor_of

from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.naming.effect_part import EffectPart
from fusion.discrepancy.naming.naming import MOST_NAMES
from fusion.discrepancy.naming.plain_pairs import like_two
from fusion.discrepancy.naming.refit import PartsFit, partial_residual, refitted
from fusion.discrepancy.naming.search.candidates import Candidate, candidate_of, candidates_of
from fusion.discrepancy.naming.search.models import rearranged
from fusion.discrepancy.observe.observations import observe
from fusion.sensor.effect import Effect
from fusion.sensor.effects.phase.cyclic_error import CyclicError
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.effects.readout.depth_scale import DepthScale
from fusion.sensor.forms import forms_of


def wave_of(period: float, *hidden: Effect) -> tuple[PartsFit, list[Candidate]]:
    """A wave that is named for what is hidden, and all candidates."""
    observations = observe(sensor_of("itof"), looks_at(sensor_of("itof", *hidden), 2))
    covariance = covariance_of(observations)
    form = next(f for f in forms_of(CyclicError, (80, 112)))
    wave = candidate_of(observations, covariance, type(form)(form.kind, {"period": period}, form.atoms, join=form.join))
    return refitted([EffectPart(wave, np.ones(2))], observations, covariance), candidates_of(observations, covariance)


def rivals(fit: PartsFit, candidates: list[Candidate]) -> tuple[str, ...]:
    space, _ = partial_residual(fit, 0)
    return tuple(
        c.name for c in like_two(fit, fit.parts[0], [c for c in candidates if c.name != "cyclic_error"], space)
    )


def test_half_a_wave_may_be_two_plain_laws_and_two_waves_not():
    half = wave_of(8.0, CyclicError(amplitude=0.02, period=8.0, phase=0.5))
    two = wave_of(0.8, CyclicError(amplitude=0.004, period=0.8, phase=0.5))
    assert len(rivals(*half)) == 2
    assert rivals(*two) == ()
    assert rearranged(*half, MOST_NAMES) is half[0]  # they explain less, if not in every recording
    assert rearranged(*two, MOST_NAMES) is two[0]


def test_a_wave_stands_for_no_offset_with_a_slope():
    """What is there are two plain laws; a wave of the right period explains them nearly as well."""
    fit, candidates = wave_of(6.0, DepthOffset(offset=0.01), DepthScale(scale=-0.01))
    assert {part.name for part in rearranged(fit, candidates, MOST_NAMES).parts} == {"depth_offset", "depth_scale"}
