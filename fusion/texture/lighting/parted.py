"""Values that views show of points, parted into one of each view, one of each point, and what goes with known terms.

The numbers of the points, thousands, are eliminated; what is left is one small system of equations.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fusion.geometry.pose import Array

ROUNDS = 8  # of weights that fall where a view does not fit
FITS = 0.3  # a value that differs by more counts less (Huber): a hand in a view must not change its exposure (guess)
USUAL = 0.5  # how large a number is (guess): what the views leave open stays near 0
PATCHES = 50  # of a view that err each for itself: neighbours err alike, as the pose and the shape are off (guess)
FINEST = 1e-3  # what is left over is no less


@dataclass(frozen=True)
class Seen:
    """What views show of points, one entry for each point in each view."""

    # view, point: (n,) which
    view: NDArray[np.int64]
    point: NDArray[np.int64]
    weight: NDArray[np.float64]  # (n,) above 0
    values: Array  # (n, c)
    terms: Array  # (n, t) what may be in the values besides


@dataclass(frozen=True)
class Parted:
    """Values as a sum."""

    views: Array  # (views, c) of each view; 0 on average
    terms: Array  # (t, c) what each term is multiplied with
    left: float  # what is left over, rms
    independent: int  # how many of the entries err each for itself

    def pays(self, plain: "Parted") -> bool:
        """Whether its terms explain more than they would by chance (Schwarz's criterion), beside a sum without them."""
        gained = 2 * self.independent * np.log(plain.left / self.left)
        return bool(gained > len(self.terms) * np.log(self.independent))


def parted(seen: Seen, views: int, points: int) -> Parted:
    """Robust least squares: the one best answer, as the norm is Huber's."""
    entries = np.arange(len(seen.view))
    of_view = sparse.csr_matrix((np.ones(len(entries)), (entries, seen.view)), (len(entries), views))
    unknown = sparse.hstack([of_view, sparse.csr_matrix(seen.terms)]).tocsr()
    of_point = sparse.csr_matrix((np.ones(len(entries)), (seen.point, entries)), (points, len(entries)))
    independent = min(PATCHES * views, len(entries))
    usual = seen.weight / seen.weight.mean() * independent / len(entries)
    weight, left = usual, FITS**2
    for _ in range(ROUNDS):
        weighted = unknown.multiply(weight[:, None]).tocsr()
        share = 1 / np.maximum(of_point @ weight, 1e-12)[:, None]
        at_points, mean = (of_point @ weighted).toarray(), of_point @ (weight[:, None] * seen.values)
        N = (unknown.T @ weighted).toarray() - at_points.T @ (at_points * share)
        b = weighted.T @ seen.values - at_points.T @ (mean * share)
        found = np.linalg.solve(N + np.eye(len(N)) * left / USUAL**2, b)
        away = seen.values - unknown @ found - ((mean - at_points @ found) * share)[seen.point]
        far = np.abs(away).max(axis=1)
        left = max(float(weight @ far**2 / weight.sum()), FINEST**2)
        weight = usual * FITS / np.maximum(far, FITS)
    own = found[:views] - found[:views].mean(axis=0)
    return Parted(own, found[views:], float(np.sqrt(left)), independent)
