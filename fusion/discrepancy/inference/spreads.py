"""Spreads: how large errors beside the covariance are, of every tile and of every recording, and where."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

# freedom of the t distribution of recordings: the usual one where a few of them are far off (Lange, Little and Taylor,
# 1989); a recording's own spread counts as much as that of so many tiles that are as usual
TAILS = 4.0
ROUNDS = 25
ENOUGH = 0.02  # relative change of a variance from which on rounds go on


@dataclass(frozen=True)
class Left:
    """What no law reaches, as known and unknown errors make it."""

    white: Vector  # (m,) in units of the covariance: of unit spread were it not for errors beside it
    rough: Matrix  # (n, m) by how much an error of each tile changes it [1 / native unit]
    smooth: Matrix  # (n, k) columns of which the products sum up to the covariance of a drift of unit spread
    place: NDArray[np.intp]  # (n,) recording of each tile, from 0 on


@dataclass(frozen=True)
class Spreads:
    """Errors beside the covariance."""

    # scatter, drift: standard deviations [native unit] of a tile for itself, and of a smooth field of a recording
    scatter: float
    drift: float = 0.0
    # variance of both in recording 0, 1, ... over the usual one; empty where they are even.
    uneven: tuple[float, ...] = ()
    cost: float = np.inf  # -2 log of the restricted likelihood


def likeliest(left: Left, start: Spreads) -> Spreads:
    """The spreads of the largest restricted likelihood, from a start on; a drift of 0 stays none.

    Each variance is multiplied by what it explains over what it is expected to explain, until nothing changes.
    """
    places = int(np.max(left.place)) + 1
    size = np.array([start.scatter**2, start.drift**2])
    uneven = np.array(start.uneven or np.ones(places))
    for turn in range(ROUNDS + 1):
        cost, found, foreseen = _told(left, size, uneven)
        more = np.where(size > 0, found @ uneven / np.maximum(foreseen @ uneven, 1e-300), 1.0)
        own = (uneven * (size @ found) + TAILS / uneven) / (uneven * (size @ foreseen) + TAILS)
        own = own if places > 1 else np.ones(1)
        if turn == ROUNDS or np.all(np.abs(np.log([*more, *own])) < ENOUGH):
            break
        size, uneven = size * more, uneven * own
    scatter, drift = np.sqrt(size).tolist()
    return Spreads(scatter, drift, tuple(uneven.tolist()), cost)


def _told(left: Left, size: Vector, uneven: Vector) -> tuple[float, Matrix, Matrix]:
    """Cost of variances (2,) of scatter and drift; (2, places) what each explains, and what it is expected to."""
    rows = [np.flatnonzero(left.place == g) for g in range(len(uneven))]
    fields = [left.smooth[own] @ left.smooth[own].T for own in rows]
    covariance = np.eye(len(left.white))
    for own, field, k in zip(rows, fields, uneven, strict=True):
        part = left.rough[own]
        covariance += k * (part.T @ (size[0] * part + size[1] * (field @ part)))
    lower = cholesky(covariance, lower=True, overwrite_a=True, check_finite=False)
    both = np.column_stack([left.white, left.rough.T])
    both = np.asarray(solve_triangular(lower, both, lower=True, overwrite_b=True, check_finite=False))
    white, seen = both[:, 0], both[:, 1:]
    pull = seen.T @ white
    found, foreseen = np.zeros((2, len(rows))), np.zeros((2, len(rows)))
    for g, (own, field) in enumerate(zip(rows, fields, strict=True)):
        products = seen[:, own].T @ seen[:, own]
        found[:, g] = pull[own] @ pull[own], pull[own] @ field @ pull[own]
        foreseen[:, g] = np.trace(products), (products * field).sum()
    cost = float(2 * np.log(np.diag(lower)).sum() + white @ white)
    return cost + TAILS * float((np.log(uneven) + 1.0 / uneven - 1.0).sum()), found, foreseen
