"""Evidence: what tells a law from chance, and whether recordings that took no part in a fit show it too."""

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, fdtrc

from fusion.discrepancy.inference.tile_covariance import TileCovariance
from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.discrepancy.naming.search.score import Scored
from fusion.geometry.robust import robust_std

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

RIDGE = 1e-4  # of the mean power of the columns of smooth functions
FAINT = 1e-6  # of the power that columns without any are taken to have


def damping(normal: Matrix, ridge: float) -> float:
    """What is added to the diagonal (k, k) of a normal matrix: a share of the mean power of its columns."""
    return ridge * max(float(np.trace(normal)), FAINT) / max(len(normal), 1)


def left_out_gain(
    seen: Matrix, target: Vector, place: NDArray[np.intp], size: float = 0.0, ridge: float = 1e-9
) -> float:
    """Drop of the chi2 in each recording, with weights of columns (n, k) fitted to the others.

    Args:
        size: usual one of the weights of a field.
        ridge: of the mean power of other columns: where the data say nothing, a weight is small.
    """
    total = 0.0
    normal, moment = seen.T @ seen, seen.T @ target
    normal = normal + np.eye(len(normal)) * (size**-2 if size else damping(normal, ridge))
    for g in np.unique(place):
        own, aim = seen[place == g], target[place == g]
        weights = np.linalg.solve(normal - own.T @ own, moment - own.T @ aim)
        total += float(aim @ aim - ((aim - own @ weights) ** 2).sum())
    return total


def replicated_share(
    candidate: Candidate, place: NDArray[np.intp], covariance: TileCovariance, target: Vector
) -> float:
    """Share of the gain that recordings left out show of an effect that the model holds already.

    What is known of its size couples all recordings, so that one of them alone tells nothing in its units.
    Here each recording stands for itself, without that knowledge.
    """
    raw, columns = covariance.root @ target, candidate.columns
    powers, moments = [], []
    for g in np.unique(place):
        rows = place == g
        own = covariance.root[rows] @ covariance.root[rows].T - covariance.known[rows] @ covariance.known[rows].T
        solved = np.linalg.solve(own, np.column_stack([columns[rows], raw[rows]]))
        powers.append(columns[rows].T @ solved[:, :-1])
        moments.append(columns[rows].T @ solved[:, -1])
    normal, moment = np.sum(powers, axis=0), np.sum(moments, axis=0)
    whole = float(moment @ np.linalg.pinv(normal) @ moment)
    total = 0.0
    for power, own_moment in zip(powers, moments, strict=True):
        weights = np.linalg.pinv(normal - power) @ (moment - own_moment)
        total += float(2 * weights @ own_moment - weights @ power @ weights)
    return total / whole if whole > 0 else 0.0


def by_chance(found: Scored, fitted: Vector, target: Vector, tried: int) -> float:
    """Probability that noise alone makes one of so many names explain as much of a target (n,).

    What a law says of a handful of tiles is judged by a handful of numbers, and not as if their spread was known from
    all the others: real tiles far out are more frequent than normal ones.
    """
    gain = found.gain / inflation(target - fitted)
    own = fitted**2
    tiles = float(own.sum() ** 2 / max(float((own**2).sum()), 1e-300))
    if found.size:  # the many weights of a field have paid for themselves
        return float(min(1.0, tried * chdtrc(found.freedom, gain)))
    return float(min(1.0, tried * fdtrc(found.freedom, max(tiles - 1.0, 1.0), gain / found.freedom)))


def inflation(white: Vector) -> float:
    """By how much (at least 1) the bulk of the residuals scatters more than the covariance says."""
    return max(1.0, robust_std(white) ** 2)


def gain_elsewhere(columns: Vector, white: Vector, place: NDArray[np.intp], ridge: float = RIDGE) -> float:
    """Drop of the chi2 in each recording, with weights fitted to the others; of a single one, in four parts of it."""
    groups = place if len(np.unique(place)) > 1 else np.arange(len(place)) * 4 // max(len(place), 1)
    return left_out_gain(columns, white, groups, ridge=ridge)


def weights_of(columns: Vector, white: Vector, ridge: float = RIDGE) -> Vector:
    """Least squares; where the data say nothing, the weight is small."""
    normal = columns.T @ columns
    normal += damping(normal, ridge) * np.eye(len(normal))
    return np.asarray(np.linalg.solve(normal, columns.T @ white))
