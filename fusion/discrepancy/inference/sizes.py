"""Sizes: how large the parts of one covariance are, found together from what no law reaches (restricted likelihood)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

from fusion.discrepancy.decisions import SURE

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

FAINT = 1e-2  # of the largest direction of a part: what is left out tells next to nothing of its size
ROUNDING = 1e-6  # of the longest of some directions
STARTS = np.geomspace(1e-3, 1e3, 25)  # variances over that of the noise, where a part shows, that are tried
NOTHING = float(np.log(1e-9))  # share of the sum of squares, as a logarithm: less noise than that is none


@dataclass(frozen=True)
class Sizes:
    """Variances that are likeliest together.

    Attributes:
        noise: of all directions alike.
        variances: of each part; 0 where the data do not ask for it.
        cost: -2 log of the restricted likelihood.
    """

    noise: float
    variances: tuple[float, ...]
    cost: float


def sizes_of(white: Vector, parts: Sequence[Matrix], freedom: int, unusual: Sequence[float] = ()) -> Sizes:
    """The likeliest sizes of the parts of a covariance; a part is there only where that is likelier by `SURE`.

    Parts join one by one, the most telling first, and all that have joined are sized together.

    Args:
        white: (n,) in units of the noise, without what laws reach.
        parts: (n, k) columns whose products, times a variance, sum up to the covariance that a part adds to the noise.
        freedom: number of independent directions of `white`.
        unusual: what a unit of each variance costs as it is unusual; nothing where none is given.
    """
    total, priced = float(white @ white), np.array([*unusual] or np.zeros(len(parts)))
    best = Sizes(total / freedom, (), freedom * (np.log(total / freedom) + 1.0))
    reduced = {k: independent(part) for k, part in enumerate(parts) if np.any(part)}
    alone = {k: _sized(white, [part], freedom, priced[[k]]) for k, part in reduced.items()}
    joined: list[int] = []
    for k in sorted(alone, key=lambda k: alone[k].cost):
        own = (*best.variances, alone[k].variances[0])
        both = [*joined, k]
        found = alone[k] if not joined else _sized(white, [reduced[i] for i in both], freedom, priced[both], own)
        if best.cost - found.cost > SURE:
            joined, best = [*joined, k], found
    for k in joined[:-1]:  # what joined first may be what a later one explains better
        rest = [i for i in joined if i != k]
        own = tuple(v for i, v in zip(joined, best.variances, strict=True) if i != k)
        found = _sized(white, [reduced[i] for i in rest], freedom, priced[rest], own if rest[1:] else None)
        if found.cost - best.cost <= SURE:
            joined, best = rest, found
    variances = np.zeros(len(parts))
    variances[joined] = best.variances
    return Sizes(best.noise, tuple(variances.tolist()), best.cost)


def _sized(
    white: Vector, parts: Sequence[Matrix], freedom: int, priced: Vector, start: Sequence[float] | None = None
) -> Sizes:
    """All parts and the noise, from starting variances on; of one part alone these are searched.

    Args:
        freedom: number of independent directions of `white`.
        priced: (parts,) what a unit of each variance costs.
    """
    total = float(white @ white)
    columns = np.concatenate(parts, axis=1)
    place = np.concatenate([np.full(part.shape[1], k) for k, part in enumerate(parts)])
    normal, moment = columns.T @ columns, columns.T @ white

    def cost(logarithms: Vector) -> float:
        noise, variances = float(np.exp(logarithms[0])), np.exp(logarithms[1:])
        size = np.sqrt(variances)[place]
        factor = cho_factor(noise * np.eye(len(place)) + normal * np.outer(size, size), check_finite=False)
        told = float(size * moment @ cho_solve(factor, size * moment, check_finite=False))
        logarithm = 2 * float(np.log(np.diag(factor[0])).sum())
        rest = logarithm + (freedom - len(place)) * float(logarithms[0]) + (total - told) / noise
        return rest + float(priced @ variances)

    if start is None:
        power = np.diag(normal)  # the columns of one part are independent directions
        each, alone = moment**2 / power, total / freedom
        floor = np.log(max(alone, 1e-300)) + NOTHING  # where these explain all, no noise would be the likeliest

        def quick(logarithms: Vector) -> float:
            noise, size = np.exp(np.maximum(logarithms, floor))
            both = noise + size * power
            rest = (freedom - len(power)) * np.log(noise) + max(total - float(each.sum()), 0.0) / noise
            return float(rest + (np.log(both) + each / both).sum() + priced[0] * size)

        begins = [np.log([alone / (1 + t), alone * t / (1 + t) / float(np.median(power))]) for t in STARTS]
        found = minimize(quick, min(begins, key=quick), method="Nelder-Mead", options={"xatol": 0.01, "fatol": 0.01})
    else:
        begin = np.log([total / freedom / 2, *np.maximum(start, 1e-300)])
        found = minimize(
            cost, begin, method="Nelder-Mead", options={"xatol": 0.03, "fatol": 0.1, "maxiter": 60 * len(begin)}
        )
    return Sizes(float(np.exp(found.x[0])), tuple(np.exp(found.x[1:]).tolist()), float(found.fun))


def independent(columns: Matrix) -> Matrix:
    """(n, r) columns with nearly the same products among tiles, along independent directions."""
    values, vectors = np.linalg.eigh(columns.T @ columns)
    return np.asarray(columns @ vectors[:, values > FAINT * max(float(values[-1]), 1e-300)])


def orthonormal(columns: Matrix) -> Matrix:
    """(n, r) directions that span columns (n, k), whatever their lengths."""
    lengths = np.linalg.norm(columns, axis=0)
    if columns.shape[1] == 1:
        return columns / lengths if lengths[0] > 0 else columns[:, :0]
    left, values, _ = np.linalg.svd(columns[:, lengths > 0] / lengths[lengths > 0], full_matrices=False)
    return np.asarray(left[:, values > ROUNDING * np.max(values, initial=0.0)])
