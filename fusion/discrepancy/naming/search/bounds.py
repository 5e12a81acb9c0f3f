"""Bounds: the edges of a region, moved between bins to where a candidate explains most."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from fusion.discrepancy.inference.tile_covariance import MeasuredTiles, TileCovariance
from fusion.discrepancy.naming.effect_part import is_field
from fusion.discrepancy.naming.search.candidates import Candidate, candidate_of
from fusion.discrepancy.naming.search.score import scored
from fusion.discrepancy.naming.search.space import Aim
from fusion.discrepancy.observe.observations import Observations
from fusion.sensor.where import VARIABLES, Bound

Vector = NDArray[np.float64]

STOPS = 12  # of an edge on its way, as many tiles between any two: what it explains may have several peaks
TWEAKS = 6  # evaluations beside the best of them
REACH = 20  # an edge may move by this part of the tiles


def tweaked(
    candidate: Candidate,
    bound: Bound,
    values: Vector,
    measured: MeasuredTiles,
    aim: Aim,
) -> Candidate:
    """The candidate in a region whose edges were moved, pixel by pixel, to where they explain most."""
    space, target = aim
    values = np.sort(values)
    cut_to = _cutter(candidate, bound.variable, *measured)

    def within(low: float, high: float) -> Candidate:
        return cut_to(Bound(bound.variable, low, high))

    low, high = bound.low, bound.high
    start = within(low, high)
    # the edges of a field are moved with its weights as they are
    weights = scored(start, space.of(start.white), target).weights if is_field(candidate) else None

    def score(low: float, high: float) -> float:
        seen = space.of(within(low, high).white)
        if weights is None:
            return scored(candidate, seen, target).gain
        line = seen @ weights
        return float((line @ target) ** 2 / max(float(line @ line), 1e-300))

    for side in ("low", "high"):
        edge = low if side == "low" else high
        if not np.isfinite(edge):
            continue
        ends = _around(values, edge)
        if ends[1] <= ends[0]:
            continue

        def loss(x: float, side: str = side, low: float = low, high: float = high) -> float:
            return -score(x, high) if side == "low" else -score(low, x)

        if weights is None:
            ends = _beside_best(loss, values, ends)
        found = minimize_scalar(loss, bounds=ends, method="bounded", options={"maxiter": TWEAKS})
        if -found.fun > score(low, high):
            low, high = (float(found.x), high) if side == "low" else (low, float(found.x))
    return within(low, high)


def _beside_best(loss: Callable[[float], float], values: Vector, ends: tuple[float, float]) -> tuple[float, float]:
    """The stops on both sides of the best one, between two ends."""
    within = values[(values >= ends[0]) & (values <= ends[1])]
    stops = np.unique(np.concatenate([ends, np.quantile(within, np.linspace(0, 1, STOPS))]))
    best = int(np.argmin([loss(float(stop)) for stop in stops]))
    return float(stops[max(best - 1, 0)]), float(stops[min(best + 1, len(stops) - 1)])


def _cutter(
    candidate: Candidate, variable: str, observations: Observations, covariance: TileCovariance
) -> Callable[[Bound], Candidate]:
    """Makes a candidate that acts within a bound of a variable only; what it changes everywhere is computed once."""
    if candidate.form.map:
        return lambda bound: candidate_of(observations, covariance, candidate.form, (bound,))
    values, changes = [], []
    for patch in observations.patches:
        (order, _), shape = patch.tiles.members, patch.tiles.label.shape
        with np.errstate(all="ignore"):
            value = VARIABLES[variable](patch.depth, patch.view)
            own = [patch.change(effect) for effect in candidate.form.instances()]
        values.append(np.broadcast_to(value, shape).ravel()[order])
        changes.append(np.stack([np.broadcast_to(change, shape).ravel()[order] for change in own]))
    # pixel by pixel, those of one tile together
    value, change = np.concatenate(values), np.nan_to_num(np.concatenate(changes, axis=1), posinf=0, neginf=0)
    pixels = np.concatenate([patch.tiles.pixels for patch in observations.patches])
    number = np.repeat(np.arange(len(pixels)), pixels.astype(int))
    starts = np.append(0, np.cumsum(pixels.astype(int))[:-1])
    least, most = np.minimum.reduceat(value, starts), np.maximum.reduceat(value, starts)
    whole = np.add.reduceat(change, starts, axis=1)

    def cut(bound: Bound) -> Candidate:
        sums = np.where((least >= bound.low) & (most <= bound.high), whole, 0.0)
        parted = ~((least >= bound.low) & (most <= bound.high) | (most < bound.low) | (least > bound.high))
        some = np.flatnonzero(parted[number])  # pixels of tiles that an edge goes through
        acts = some[(value[some] >= bound.low) & (value[some] <= bound.high)]
        sums += [np.bincount(number[acts], own[acts], minlength=len(pixels)) for own in change]
        columns = (sums / pixels).T
        return Candidate(candidate.form, columns, covariance.whiten(columns), (bound,))

    return cut


def _around(values: Vector, edge: float) -> tuple[float, float]:
    """Where an edge may really be: between the next values on both sides that are clearly others."""
    below, above = values[values < edge - 1e-6], values[values > edge + 1e-6]
    reach = len(values) // REACH
    low = min(below[-1], values[max(len(below) - reach, 0)]) if len(below) else edge
    high = max(above[0], values[min(len(values) - len(above) + reach, len(values) - 1)]) if len(above) else edge
    return float(low), float(high)
