"""Elsewhere: what columns fitted to some recordings say of others."""

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

FAINT = 1e-6  # of the power that columns without any are taken to have


def gain_elsewhere(columns: Vector, white: Vector, place: NDArray[np.intp], ridge: float = 1e-4) -> float:
    """Drop of the chi2 in each recording, with weights fitted to the others; of a single one, in four parts of it."""
    groups = place if len(np.unique(place)) > 1 else np.arange(len(place)) * 4 // max(len(place), 1)
    normal, moment, total = columns.T @ columns, columns.T @ white, 0.0
    damped = ridge * max(float(np.trace(normal)), FAINT) / max(len(normal), 1) * np.eye(len(normal))
    for g in np.unique(groups):
        own, w = columns[groups == g], white[groups == g]
        weights = np.linalg.solve(normal - own.T @ own + damped, moment - own.T @ w)
        total += float(w @ w - ((w - own @ weights) ** 2).sum())
    return total
