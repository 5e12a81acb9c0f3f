"""Review: after each acceptance, regions get their best edges, and every name is tried against its rivals."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fusion.discrepancy.decisions import SURE
from fusion.discrepancy.inference.tile_covariance import MeasuredTiles
from fusion.discrepancy.naming.effect_part import EffectPart
from fusion.discrepancy.naming.refit import PartsFit, partial_residual, refitted
from fusion.discrepancy.naming.search.bounds import tweaked
from fusion.discrepancy.naming.search.candidates import Candidate, candidate_of
from fusion.discrepancy.naming.search.region import region_variables
from fusion.discrepancy.naming.search.score import scored
from fusion.discrepancy.naming.search.step import scores
from fusion.sensor.where import Bound

ROUNDS = 2


def reviewed(fit: PartsFit, candidates: Sequence[Candidate]) -> PartsFit:
    """The fit with regions where they explain most, each part the best of its rivals."""
    for _ in range(ROUNDS):
        fit = _edged(fit)
        swapped = _swapped(fit, candidates)
        if swapped is None:
            break
        fit = swapped
    return fit


def _edged(fit: PartsFit) -> PartsFit:
    """Regions with their edges where they explain most beside the other parts: of all waves of an effect the same."""
    if not any(part.candidate.where for part in fit.parts):
        return fit
    values = region_variables(fit.observations)
    strongest = {
        part.name: k
        for k, part in sorted(enumerate(fit.parts), key=lambda one: float(one[1].footprint @ one[1].footprint))
        if part.candidate.where and not part.size
    }
    for k in strongest.values():
        part = fit.parts[k]
        bound, aim = part.candidate.where[0], partial_residual(fit, k)
        measured = MeasuredTiles(fit.observations, fit.covariance)
        moved = tweaked(part.candidate, bound, values[bound.variable], measured, aim)
        weights = scored(moved, aim.space.of(moved.white), aim.target).weights
        parts = [in_region(one, moved.where, fit) if one.name == part.name else one for one in fit.parts]
        parts[k] = EffectPart(moved, weights)
        better = refitted(parts, fit.observations, fit.covariance)
        if better.white @ better.white < fit.white @ fit.white:
            fit = better
    return fit


def in_region(part: EffectPart, where: tuple[Bound, ...], fit: PartsFit) -> EffectPart:
    """A part of a fit within other bounds; without any, everywhere."""
    if part.candidate.where == where:
        return part
    return replace(part, candidate=candidate_of(fit.observations, fit.covariance, part.candidate.form, where))


def _swapped(fit: PartsFit, candidates: Sequence[Candidate]) -> PartsFit | None:
    """The fit with one part replaced by a rival that explains more beside the others; None where none does."""
    if len(fit.parts) < 2:
        return None
    for k, part in enumerate(fit.parts):
        space, target = partial_residual(fit, k)
        own = scored(part.candidate, space.of(part.candidate.white), target)
        taken = {other.name for i, other in enumerate(fit.parts) if i != k}
        rivals = [c for c in candidates if c.name != part.name and c.name not in taken]
        if not rivals:
            continue
        results = scores(rivals, space, target)
        best = int(np.argmax([one.score for one in results]))
        if results[best].score <= own.score + SURE:
            continue
        rival = rivals[best]
        if part.candidate.where:
            confined = candidate_of(fit.observations, fit.covariance, rival.form, part.candidate.where)
            inside = scored(confined, space.of(confined.white), target)
            if inside.score > results[best].score:
                rival, results[best] = confined, inside
        new = EffectPart(rival, results[best].weights, results[best].size)
        better = refitted([*fit.parts[:k], new, *fit.parts[k + 1 :]], fit.observations, fit.covariance)
        if better.white @ better.white < fit.white @ fit.white:
            return better
    return None
