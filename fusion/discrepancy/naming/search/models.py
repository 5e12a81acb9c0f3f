"""Models: all sets of a few names at once, as one flexible law found first may stand for two plain ones together."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, islice

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.decisions import REPLICATED, SURE
from fusion.discrepancy.naming.effect_part import FIELD, EffectPart
from fusion.discrepancy.naming.evidence import left_out_gain
from fusion.discrepancy.naming.refit import PartsFit, partial_residual, refitted, shapes_of
from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.discrepancy.naming.search.score import possible, scored
from fusion.discrepancy.naming.search.step import SIMPLER, of_time

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

SHAPES = 3  # of each name that are tried: those that explain most alone
# sets of each size that are fitted through the sensor itself: a linear score promises too much, or too little
TRIED = 2
FAINT = 1e-9  # of a direction's power: columns of two forms that are one


@dataclass(frozen=True)
class _Pool:
    """Forms, what the freedom of each costs, and products of their whitened columns, also with the residual."""

    forms: tuple[Candidate, ...]
    prices: tuple[float, ...]
    places: tuple[slice, ...]
    products: Matrix
    moments: Vector


def rearranged(fit: PartsFit, candidates: Sequence[Candidate], most: int) -> PartsFit:
    """The fit, or another of at most `most` names that explains clearly more for what its freedom costs.

    Every part of the other one must help, replicate and stay within its range. A field may have followed several plain
    laws at once, and gives way to them; effects that the model holds are left as they are.
    """
    if not fit.parts or any(fit.observations.sensor.effect(part.name) for part in fit.parts):
        return fit
    own, white = score_of(fit), fit.covariance.whiten(fit.observations.residual)
    least = float(white @ white) - own - SURE  # cost and price together that the other must stay below
    for parts in _promising(fit, candidates, most):
        price = sum(map(_freedom, parts)) * float(np.log(len(white)))
        other = refitted(parts, fit.observations, fit.covariance, least - price)
        if score_of(other) > own + SURE and all(_sound(other, k) for k in range(len(other.parts))):
            return other
    return fit


def score_of(fit: PartsFit) -> float:
    """Drop of the chi2 by all parts together, less the logarithm of the number of tiles for every number fitted.

    A field costs what it does where it is chosen: the many of its weights are draws of one size.
    """
    white = fit.covariance.whiten(fit.observations.residual)
    each = float(np.log(len(white)))
    price = sum(_paid(fit, k) if part.size else _freedom(part) * each for k, part in enumerate(fit.parts))
    return float(white @ white - fit.white @ fit.white) - price


def _paid(fit: PartsFit, k: int) -> float:
    """What the freedom of a field costs beside the other parts."""
    space, target = partial_residual(fit, k)
    candidate = fit.parts[k].candidate
    own = scored(candidate, space.of(candidate.white), target)
    return own.gain - own.score


def _freedom(part: EffectPart) -> int:
    bounds = sum(int(np.isfinite(bound.low)) + int(np.isfinite(bound.high)) for bound in part.candidate.where)
    return len(part.weights) + len(shapes_of(part)) + bounds


def _sound(fit: PartsFit, k: int) -> bool:
    part = fit.parts[k]
    if part.at_bound(fit.observations):
        return False
    space, target = partial_residual(fit, k)
    seen = space.of(part.candidate.white)
    own = scored(part.candidate, seen, target)
    place = fit.observations.block_number if of_time(part.candidate) else fit.observations.replicate
    return own.score > 0 and left_out_gain(seen, target, place) >= REPLICATED * own.gain


def _promising(fit: PartsFit, candidates: Sequence[Candidate], most: int) -> Iterator[list[EffectPart]]:
    """Of each size, the smallest first, the sets of names with the best linear score."""
    white = fit.covariance.whiten(fit.observations.residual)
    pool = _pool(candidates, fit, white)
    names = [form.name for form in pool.forms]
    for size in range(1, most + 1):
        found: dict[tuple[str, ...], tuple[float, tuple[int, ...], Vector]] = {}
        for chosen in combinations(range(len(names)), size):
            key = tuple(names[i] for i in chosen)
            if len(set(key)) < size:
                continue
            gain, weights = _solved(pool, chosen)
            score = gain - sum(pool.prices[i] for i in chosen)
            if key not in found or score > found[key][0]:
                found[key] = score, chosen, weights
        ranked = sorted(found.values(), key=lambda one: -one[0])
        made = (_parts(pool, chosen, weights) for _, chosen, weights in ranked)
        yield from islice(filter(None, made), TRIED)


def _parts(pool: _Pool, chosen: tuple[int, ...], weights: Vector) -> list[EffectPart]:
    """The parts of a set; none where one of them cannot be."""
    ends = np.cumsum([pool.places[i].stop - pool.places[i].start for i in chosen])[:-1]
    own, forms = np.split(weights, ends), [pool.forms[i] for i in chosen]
    can_be = all(possible(form, w) for form, w in zip(forms, own, strict=True))
    return [EffectPart(form, w) for form, w in zip(forms, own, strict=True)] if can_be else []


def _pool(candidates: Sequence[Candidate], fit: PartsFit, white: Vector) -> _Pool:
    """The most telling forms of each name that are no fields and that the model does not hold."""
    held = {effect.name for effect in fit.observations.sensor.effects}
    usual = [
        c for c in candidates if c.white.shape[1] < FIELD and not c.form.map and not c.where and c.name not in held
    ]
    taken: dict[str, int] = {}
    forms = [part.candidate for part in fit.parts if not part.candidate.where and not part.size]
    for one in sorted(usual, key=lambda c: -scored(c, c.white, white).gain):
        if taken.get(one.name, 0) < SHAPES and np.any(one.white):
            taken[one.name] = taken.get(one.name, 0) + 1
            forms.append(one)
    columns = np.concatenate([form.white for form in forms], axis=1)
    ends = np.cumsum([form.white.shape[1] for form in forms])
    places = tuple(slice(int(end) - form.white.shape[1], int(end)) for form, end in zip(forms, ends, strict=True))
    each = float(np.log(len(white)))
    # of laws that explain alike, those that depend on less stand for all
    prices = tuple(
        _freedom(EffectPart(form, np.zeros(form.white.shape[1]))) * each + SIMPLER * len(form.form.kind.variables)
        for form in forms
    )
    return _Pool(tuple(forms), prices, places, columns.T @ columns, columns.T @ white)


def _solved(pool: _Pool, chosen: tuple[int, ...]) -> tuple[float, Vector]:
    """Gain and weights of forms together."""
    rows = np.concatenate([np.arange(pool.places[i].start, pool.places[i].stop) for i in chosen])
    power, moment = pool.products[np.ix_(rows, rows)], pool.moments[rows]
    scale = 1.0 / np.sqrt(np.maximum(np.diag(power), 1e-300))
    even = power * scale[:, None] * scale + FAINT * np.eye(len(rows))
    weights = scale * np.linalg.solve(even, scale * moment)
    return float(moment @ weights), weights
