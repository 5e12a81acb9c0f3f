"""Review: after each acceptance, regions get their best edges, and every name is tried against its rivals."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from fusion.discrepancy.decisions import NOTICED, SURE
from fusion.discrepancy.inference.tile_covariance import MeasuredTiles
from fusion.discrepancy.naming.effect_part import EffectPart
from fusion.discrepancy.naming.refit import PartsFit, partial_residual, refitted
from fusion.discrepancy.naming.search.bounds import tweaked
from fusion.discrepancy.naming.search.candidates import Candidate, candidate_of
from fusion.discrepancy.naming.search.models import score_of
from fusion.discrepancy.naming.search.region import region_variables
from fusion.discrepancy.naming.search.score import scored
from fusion.discrepancy.naming.search.step import scores
from fusion.sensor.parameter import Parameter, parameters
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


def released(fit: PartsFit) -> PartsFit:
    """The fit with a shape of one part set free if that contradicts nothing: beside the others, or in place of another
    part or of its region.

    A drift whose zero lies at another temperature is one effect, and neither one with an offset nor one of late frames.
    """
    fewer = [one for k in range(len(fit.parts)) for one in _with_free_shape(fit, k)]
    sound = [one for one in fewer if not any(part.at_bound(fit.observations) for part in one.parts)]
    best = max(sound, key=score_of, default=fit)
    return best if score_of(best) > score_of(fit) - NOTICED else fit


def _with_free_shape(fit: PartsFit, k: int) -> Iterator[PartsFit]:
    """Fits with a shape of part k set free: beside all others, and without its region, another part, or both."""
    part = fit.parts[k]
    others = [other for other in fit.parts if other.name != part.name]
    for name, about in parameters(part.candidate.form.kind).items():
        for start in about.release if _may_be_set_free(part, about) else ():
            form = replace(part.candidate.form, fixed={**part.candidate.form.fixed, name: start})
            for where in dict.fromkeys([(), part.candidate.where]):
                free = candidate_of(fit.observations, fit.covariance, form, where)
                weights = scored(free, free.white, fit.white + part.footprint).weights
                for dropped in (*others, None):
                    if others or where != part.candidate.where:
                        rest = [one for one in fit.parts if one is not part and one is not dropped]
                        yield refitted([*rest, EffectPart(free, weights)], fit.observations, fit.covariance)


def _may_be_set_free(part: EffectPart, about: Parameter) -> bool:
    """True of a shape that belongs to what was fitted of a part and stands at its neutral value."""
    form, known = part.candidate.form, parameters(part.candidate.form.kind)
    return about.name not in form.fixed and about.group in {known[name].group for atom in form.atoms for name in atom}


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
