"""Step: the one effect that pays most for its freedom now, everywhere or in a region, with what tells if it is real."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from fusion.discrepancy.decisions import FALSE_ALARM, REPLICATED, SECOND_CAUSE, SURE
from fusion.discrepancy.inference.tile_covariance import MeasuredTiles, TileCovariance
from fusion.discrepancy.naming.effect_part import EffectPart, is_field
from fusion.discrepancy.naming.evidence import by_chance, left_out_gain, replicated_share
from fusion.discrepancy.naming.search.candidates import Candidate, candidate_of
from fusion.discrepancy.naming.search.region import OF_TIME, Regional, best_region, confined, second_cause
from fusion.discrepancy.naming.search.score import Scored, scored
from fusion.discrepancy.naming.search.space import Aim, Space
from fusion.discrepancy.observe.observations import Observations
from fusion.sensor.parameter import parameters

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

SHAPES = 2  # of each name that are tried in regions: those that explain most everywhere
REGION_GAIN = 0.04  # of the whole's gain: a region must explain that much more, or leave noise where the whole does not
WITHIN = (*OF_TIME, "table_angle")  # what changes while one recording goes on
SIMPLER = 2.0  # score per variable: of laws that fit alike, the one that depends on less


@dataclass(frozen=True)
class NextPart:
    """The best next part, and how sure it is."""

    part: EffectPart  # with weights of its own fit
    gain: float  # drop of the chi2
    score: float  # the same less the price of its freedom
    held_out: float  # drop of the chi2 in recordings left out in turn
    probability: float  # that noise alone does this, over all names and regions

    @property
    def established(self) -> bool:
        """True when chance is ruled out and recordings that took no part in the fit show it too."""
        return self.probability <= FALSE_ALARM and self.held_out >= REPLICATED * self.gain


def best_part(
    candidates: Sequence[Candidate],
    observations: Observations,
    covariance: TileCovariance,
    space: Space,
    target: Vector,
    more: float = REGION_GAIN,
) -> NextPart | None:
    """The candidate that pays most for its freedom in a space, established or not; None when there is none at all.

    Args:
        more: share of the whole's gain that it must explain beyond that in a region.
    """
    if not candidates:
        return None
    all_scored = scores(candidates, space, target)
    held = {effect.name for effect in observations.sensor.effects}
    likely = [s.score + _prior(c, held) for c, s in zip(candidates, all_scored, strict=True)]
    best = int(np.argmax(likely))
    if not np.isfinite(all_scored[best].score):
        return None
    whole = _tuned(candidates[best], observations, covariance, Aim(space, target))
    own = scored(whole, space.of(whole.white), target)
    candidate, result, tried = whole, own, len({c.name for c in candidates})
    regional = _regional(candidates, all_scored, observations, covariance, Aim(space, target))
    if regional is not None and _beats(regional, own, more):
        regional = _own_to_region(regional, candidates, observations, covariance, Aim(space, target))
        everywhere = candidate_of(observations, covariance, regional.candidate.form)
        if confined(regional.candidate, everywhere, space, target):
            candidate, result, tried = regional.candidate, regional.scored, tried * regional.tried
    part = EffectPart(candidate, result.weights, result.size)
    seen = space.of(candidate.white)
    probability = by_chance(result, seen @ result.weights, target, tried)
    held_out = held_out_gain(part, MeasuredTiles(observations, covariance), seen, target, result.gain)
    return NextPart(part, result.gain, result.score, held_out, probability)


def held_out_gain(part: EffectPart, measured: MeasuredTiles, seen: Matrix, target: Vector, gain: float) -> float:
    """Drop of the chi2 by columns (n, k) of a part in recordings, or blocks of a series, that are left out in turn."""
    observations, covariance = measured
    if observations.sensor.effect(part.name) is not None:
        return gain * replicated_share(part.candidate, observations.place, covariance, target)
    share = left_out_gain(seen, target, observations.replicate, part.size)
    if share < REPLICATED * gain and of_time(part.candidate):
        return left_out_gain(seen, target, observations.block_number, part.size)
    return share


def _prior(candidate: Candidate, held: set[str]) -> float:
    """What tips the balance between laws that fit alike: known ones first, then those that depend on less."""
    return (SECOND_CAUSE if candidate.name in held else 0.0) - SIMPLER * len(candidate.form.kind.variables)


def scores(candidates: Sequence[Candidate], space: Space, target: Vector) -> list[Scored]:
    """Every candidate in a space, whitened columns transformed in one go."""
    all_columns = space.of(np.concatenate([c.white for c in candidates], axis=1))
    ends = np.cumsum([c.white.shape[1] for c in candidates])
    return [
        scored(candidate, seen, target)
        for candidate, seen in zip(candidates, np.split(all_columns, ends[:-1], axis=1), strict=True)
    ]


def _regional(
    candidates: Sequence[Candidate],
    all_scored: Sequence[Scored],
    observations: Observations,
    covariance: TileCovariance,
    aim: Aim,
) -> Regional | None:
    """The best candidate in a region, among the most telling shapes of each name."""
    ranked = sorted(range(len(candidates)), key=lambda i: -all_scored[i].gain)
    taken: dict[str, int] = {}
    chosen = []
    for i in ranked:
        name = candidates[i].name
        if taken.get(name, 0) < SHAPES and not candidates[i].where and not _of_table(candidates[i]):
            taken[name] = taken.get(name, 0) + 1
            chosen.append((candidates[i], all_scored[i].weights))
    return best_region(chosen, observations, covariance, *aim)


def _beats(regional: Regional, whole: Scored, more: float) -> bool:
    asked = 0.0 if whole.size else more * whole.gain  # a field has paid for its freedom already
    return regional.scored.score > whole.score + max(SURE, asked)


def _own_to_region(
    regional: Regional,
    candidates: Sequence[Candidate],
    observations: Observations,
    covariance: TileCovariance,
    aim: Aim,
) -> Regional:
    """The law that depends on what bounds the region, in any of its shapes, where that is likelier."""
    space, target = aim
    where, cause, own = regional.candidate.where, second_cause(regional.candidate), regional
    if not cause:
        return regional
    found = scored(regional.candidate, space.of(regional.candidate.white), target)
    paid = found.score - regional.scored.score - cause
    for other in candidates:
        if not is_field(other) and not second_cause(replace(other, where=where)):
            candidate = candidate_of(observations, covariance, other.form, where)
            found = scored(candidate, space.of(candidate.white), target)
            if found.score - paid > own.scored.score:
                own = Regional(candidate, replace(found, score=found.score - paid), regional.tried)
    return own


def _of_table(candidate: Candidate) -> bool:
    """True for what moves the whole object on its table: it is not confined to a region of anything."""
    return "table_angle" in candidate.form.kind.variables


def of_time(candidate: Candidate) -> bool:
    """True for what changes while one recording goes on, so that blocks of a series tell of it, and not recordings."""
    about = {bound.variable for bound in candidate.where} | set(candidate.form.kind.variables)
    return bool(about & set(WITHIN))


def _tuned(candidate: Candidate, observations: Observations, covariance: TileCovariance, aim: Aim) -> Candidate:
    """The candidate with its searched shape parameters between the values of the search."""
    space, target = aim
    if is_field(candidate):
        return candidate
    about = parameters(candidate.form.kind)

    def gain(one: Candidate) -> float:
        return scored(one, space.of(one.white), target).gain

    for name, value in candidate.form.fixed.items():
        values = sorted(about[name].search)
        if value not in values:
            continue
        place = values.index(value)
        low, high = values[max(place - 1, 0)], values[min(place + 1, len(values) - 1)]
        if not low < high or value <= 0:
            continue

        def with_(x: float, name: str = name, start: Candidate = candidate) -> Candidate:
            form = replace(start.form, fixed={**start.form.fixed, name: x})
            return candidate_of(observations, covariance, form, start.where)

        def loss(x: float, made: object = with_) -> float:
            return -gain(made(x))  # type: ignore[operator]

        options = {"xatol": 1e-3 * value, "maxiter": 12}
        found = minimize_scalar(loss, bounds=(low, high), method="bounded", options=options)
        if -found.fun > gain(candidate):
            candidate = with_(float(found.x))
    return candidate
