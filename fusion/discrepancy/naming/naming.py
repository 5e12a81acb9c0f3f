"""Naming: which effects, added to the model, explain the residual; each must pay, replicate and fit."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.decisions import FALSE_ALARM, NOISE_ALONE, SURE
from fusion.discrepancy.inference.tile_covariance import TileCovariance
from fusion.discrepancy.naming.assessment import Step, judged, judged_next
from fusion.discrepancy.naming.effect_part import EffectPart
from fusion.discrepancy.naming.established import LIKELY, gain_of, is_faint, weak_of, without_faint
from fusion.discrepancy.naming.refit import PartsFit, partial_residual, refitted
from fusion.discrepancy.naming.search.candidates import Candidate, candidate_of
from fusion.discrepancy.naming.search.models import rearranged, score_of
from fusion.discrepancy.naming.search.review import in_region, released, reviewed
from fusion.discrepancy.naming.search.step import REGION_GAIN, NextPart, best_part
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.observations import Observations
from fusion.sensor.sensor import Sensor
from fusion.sensor.where import Bound

Vector = NDArray[np.float64]

MOST_STEPS = 6  # waves of one effect count one by one
MOST_NAMES = 3


@dataclass(frozen=True)
class Named:
    """What naming found.

    Attributes:
        steps: the most telling first.
        sensor: the model with all of them.
        observations: under that model.
        white: (n,) what is left, in units of the covariance.
        likely: what is likely but not established: the next one, or all where no claim stands.
        suggested: the model with what is likely, where that was fitted together; None elsewhere.
    """

    steps: tuple[Step, ...]
    sensor: Sensor
    observations: Observations
    white: Vector
    likely: tuple[Step, ...] = ()
    suggested: Sensor | None = None


def name_effects(
    blocks: Sequence[FrameBlock],
    observations: Observations,
    covariance: TileCovariance,
    candidates: Sequence[Candidate],
) -> Named:
    """Add effects one by one while they pass the tests; `candidates` are those of the given model.

    What was found one by one is then tried against all sets of as many names.
    """
    fit, likely = _grown(refitted((), observations, covariance), candidates)
    if any(part.candidate.where for part in fit.parts):
        # what a first part cannot explain alone, as several waves, it may fit best in a part of the data
        parts = [in_region(part, (), fit) for part in fit.parts]
        wide = _grown(refitted(parts, observations, covariance), candidates)
        if score_of(wide[0]) > score_of(fit) + SURE:
            fit, likely = wide
    elif fit.parts and not _is_noise(fit):
        narrow = _grown(refitted((), observations, covariance), candidates, more=0.0)
        if _is_noise(narrow[0]) and score_of(narrow[0]) > score_of(fit) + SURE:
            fit, likely = narrow
    other = rearranged(fit, candidates, MOST_NAMES)
    if other is not fit:
        fit, likely = _grown(other, candidates)
    fit, fallen = _within_bounds(released(fit))
    likely = likely or (judged_next(fit, fallen, candidates) if fallen else None)
    steps = judged(fit, candidates)
    while poorer := _poorer(fit, steps):
        fit, taken_out = poorer
        if likely is None and taken_out.held_out > 0 and taken_out.probability <= LIKELY:
            likely = taken_out
        steps = judged(fit, candidates)
    better = observations.under(fit.sensor) if steps else observations
    return Named(tuple(steps), fit.sensor, better, fit.white, (likely,) if likely else ())


def _poorer(fit: PartsFit, steps: Sequence[Step]) -> tuple[PartsFit, Step] | None:
    """The fit without a step that does not stand beside the others, and that step; None where all of them do."""
    weak = weak_of(steps)
    if not weak:
        return without_faint(fit, steps)
    rest = [part for part in fit.parts if part.candidate is not weak[-1].candidate]
    return refitted(rest, fit.observations, fit.covariance), weak[-1]


def _is_noise(fit: PartsFit) -> bool:
    return float(fit.white @ fit.white) <= NOISE_ALONE * len(fit.white)


def _grown(fit: PartsFit, candidates: Sequence[Candidate], more: float = REGION_GAIN) -> tuple[PartsFit, Step | None]:
    """The fit with further parts, one by one, and what is likely beside them; of regions as `best_part` has it."""
    likely: Step | None = None
    earlier: Step | None = None  # likely beside fewer parts
    passed_over: set[str] = set()
    for _ in range(len(fit.parts), MOST_STEPS):
        space, target = partial_residual(fit, None)
        candidates = _in_regions(candidates, fit)
        open_to = [c for c in candidates if c.name not in passed_over]
        found = best_part(open_to, fit.observations, fit.covariance, space, target, more)
        if found is None or found.probability > FALSE_ALARM or is_faint(fit, found):
            return fit, likely or _told_of(fit, found, open_to) or earlier
        if len({part.name for part in (*fit.parts, found.part)}) > MOST_NAMES:
            break
        larger = _with(fit, found, candidates) if found.established else None
        waves = [c for c in open_to if c.name == found.part.name]
        if larger is None and found.established and found.part.name in {part.name for part in fit.parts}:
            # a wave beside another may have explained what its period would, were it linear in that
            own = best_part(waves, fit.observations, fit.covariance, *partial_residual(fit, None, held=True), more)
            larger = _with(fit, own, candidates) if own is not None and own.established else None
        if larger is None:
            passed_over.add(found.part.name)  # in full, or in new recordings, it does not help
            likely = likely or _told_of(fit, found, open_to)
            continue
        fit, earlier, likely = larger, likely or earlier, None
    return fit, likely or earlier


def _with(fit: PartsFit, found: NextPart, candidates: Sequence[Candidate]) -> PartsFit | None:
    """The fit with a further part; None where it does not help in full."""
    larger = refitted(_of_one_region([*fit.parts, found.part], fit), fit.observations, fit.covariance)
    helped = larger.white @ larger.white < fit.white @ fit.white - 0.5 * found.gain
    return reviewed(larger, candidates) if helped else None


def _in_regions(candidates: Sequence[Candidate], fit: PartsFit) -> list[Candidate]:
    """Forms of effects that act in a region there alone: their further parts are asked for where the first ones act."""
    regions = {part.name: part.candidate.where for part in fit.parts}
    return [
        one
        if (where := regions.get(one.name, ())) == one.where
        else candidate_of(fit.observations, fit.covariance, one.form, where)
        for one in candidates
    ]


def _of_one_region(parts: Sequence[EffectPart], fit: PartsFit) -> list[EffectPart]:
    """Parts of one effect that would act in different regions act everywhere: it has one region for all its waves."""
    regions: dict[str, set[tuple[Bound, ...]]] = {}
    for part in parts:
        regions.setdefault(part.name, set()).add(part.candidate.where)
    return [in_region(part, (), fit) if len(regions[part.name]) > 1 else part for part in parts]


def unconfirmed(named: Named, observations: Observations, white: Vector) -> Named:
    """The same where frames that took no part contradict it: nothing is established, the first name is likely."""
    first = max(named.steps, key=lambda step: step.held_out)
    return Named((), observations.sensor, observations, white, (first,))


def suggested(named: Named, observations: Observations, white: Vector) -> Named:
    """The same where the model with all names does not foresee enough: nothing is established, all of them likely."""
    return Named((), observations.sensor, observations, white, named.steps, named.sensor)


def _within_bounds(fit: PartsFit) -> tuple[PartsFit, NextPart | None]:
    """The fit without parts that are bent to the end of their range, one by one, and the last that was taken out."""
    fallen: NextPart | None = None
    while bent := [part for part in fit.parts if part.at_bound(fit.observations)]:
        fallen = NextPart(bent[0], gain_of(bent[0]), 0.0, 0.0, FALSE_ALARM)
        fit = refitted([part for part in fit.parts if part is not bent[0]], fit.observations, fit.covariance)
    return fit, fallen


def _told_of(fit: PartsFit, found: NextPart | None, candidates: Sequence[Candidate]) -> Step | None:
    """What is likely, but not established; more of a named effect is a matter of its form."""
    if found is None or found.probability > LIKELY or any(part.name == found.part.name for part in fit.parts):
        return None
    return judged_next(fit, found, candidates)
