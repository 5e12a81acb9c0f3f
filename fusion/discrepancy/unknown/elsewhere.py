"""Elsewhere: what columns fitted to some recordings say of others."""

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.naming.evidence import damping, left_out_gain

Vector = NDArray[np.float64]

RIDGE = 1e-4  # of the mean power of the columns


def gain_elsewhere(columns: Vector, white: Vector, place: NDArray[np.intp], ridge: float = RIDGE) -> float:
    """Drop of the chi2 in each recording, with weights fitted to the others; of a single one, in four parts of it."""
    groups = place if len(np.unique(place)) > 1 else np.arange(len(place)) * 4 // max(len(place), 1)
    return left_out_gain(columns, white, groups, ridge=ridge)


def weights_of(columns: Vector, white: Vector, ridge: float = RIDGE) -> Vector:
    """Least squares; where the data say nothing, the weight is small."""
    normal = columns.T @ columns
    normal += damping(normal, ridge) * np.eye(len(normal))
    return np.asarray(np.linalg.solve(normal, columns.T @ white))
