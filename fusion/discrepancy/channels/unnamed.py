"""Unnamed: what a channel shows that depends on something known, and that no effect of the catalogue explains."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls
from scipy.special import chdtrc

from fusion.discrepancy.decisions import LOST_BY_CHANCE, REPLICATED
from fusion.discrepancy.naming.evidence import gain_elsewhere, inflation, weights_of
from fusion.discrepancy.unknown.unrestricted import hats, knots_of
from fusion.geometry.robust import robust_std

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

KNOTS = 5
RIDGE = 1e-6  # of the mean power of the columns: rounding
MOST = 2  # variables
OUTLIER = 8.0  # times what the tiles are usually off (at least their noise): beyond, a tile counts no more
WORTH = 0.15  # of the gain of the first variable: one that brings less is not named


@dataclass(frozen=True)
class Unnamed:
    """A law without a name."""

    variables: tuple[str, ...]  # it depends on
    gain: float  # drop of the chi2
    probability: float  # of that by chance
    fitted: Vector  # (n,) what it changes
    # knots, heights: of each variable, straight in between: the law is their sum
    knots: tuple[Vector, ...]
    heights: tuple[Vector, ...]


def unnamed(excess: Vector, sigma: Vector, place: NDArray[np.intp], variables: dict[str, Vector]) -> Unnamed | None:
    """The variables whose smooth functions explain tiles (n,) also in recordings left out; None when none do.

    Args:
        excess: measured less predicted, with standard deviations `sigma`.
        place: recording of each.
        variables: (n,) each, by name.
    """
    if len(np.unique(place)) < 3 or len(excess) < 10 * KNOTS:
        return None
    white = whitened(excess, sigma)
    nodes = {name: knots_of(values, KNOTS) for name, values in variables.items() if np.ptp(values) > 0}
    columns = {name: hats(variables[name], at) / sigma[:, None] for name, at in nodes.items()}
    chosen: list[str] = []
    gains: list[float] = []
    for _ in range(MOST):
        rest = {name: _gain(white, [columns[n] for n in (*chosen, name)]) for name in columns if name not in chosen}
        best = max(rest, key=lambda name: rest[name], default=None)
        if best is None or (chosen and rest[best] - gains[-1] < WORTH * gains[0]):
            break
        chosen.append(best)
        gains.append(rest[best])
    if not chosen:
        return None
    A = np.concatenate([columns[name] for name in chosen], axis=1)
    weights = weights_of(A, white, RIDGE)
    fitted = A @ weights
    inflated = inflation(white - fitted)
    probability = float(min(1.0, len(columns) * chdtrc(A.shape[1], gains[-1] / inflated)))
    if probability > LOST_BY_CHANCE or gain_elsewhere(A, white, place, RIDGE) < REPLICATED * gains[-1]:
        return None
    ends = np.cumsum([columns[name].shape[1] for name in chosen])[:-1]
    heights = tuple(np.split(weights, ends))
    return Unnamed(
        tuple(chosen), gains[-1], probability, fitted * sigma, tuple(nodes[name] for name in chosen), heights
    )


def rising_gain(excess: Vector, sigma: Vector, values: Vector) -> float:
    """Drop of the chi2 by the best function that only rises with `values` (n,), from 0 or more."""
    white = whitened(excess, sigma)
    each = hats(values, knots_of(values, KNOTS)) / sigma[:, None]
    # the sum of all hats from one knot on is a rise up to that knot
    rises = np.cumsum(each[:, ::-1], axis=1)[:, ::-1]
    left = float(nnls(rises, white)[1])
    return float(white @ white) - left**2


def whitened(excess: Vector, sigma: Vector) -> Vector:
    """(n,) excess in standard deviations; a few tiles far off what is usual here do not decide."""
    white = excess / sigma
    most = OUTLIER * max(1.0, robust_std(white))
    return np.clip(white, -most, most)


def _gain(white: Vector, parts: list[Matrix]) -> float:
    A = np.concatenate(parts, axis=1)
    left = white - A @ weights_of(A, white, RIDGE)
    return float(white @ white - left @ left)
