"""What the table's log adds to measured angles: its steps are measurements too, as good as they prove to be."""

import numpy as np
from numpy.typing import NDArray

from fusion.tracking.pairs import tukey

Array = NDArray[np.float64]
FEWEST = 24  # steps from which their scatter can be told
FAR = 8  # steps over which the table's scatter has added up
LEAST = 0.1  # share of the spread that is taken to be the table's in any case: 24 steps do not tell less (guess)
EXACT = 1e-5  # [rad] smallest standard deviation


def with_log(angles: Array, angle_std: Array, commanded: Array) -> Array:
    """Angles (n,) [rad] as the surface and the log together say them, 0 at the first.

    The table's own scatter adds up from step to step, the noise of the measurement does not: the spread of measured
    minus told turns over one step and over several tells them apart, and slow errors of the measurement count as
    scatter. Steps that do not fit (slips) take no part, so each stretch between them moves freely.

    Args:
        angles, angle_std: (n,) measured [rad], NaN where rejected.
        commanded: (n,) as told [rad], of either sign.
    """
    known = np.flatnonzero(np.isfinite(angles) & np.isfinite(angle_std))
    steps, gaps = np.diff(angles[known]), np.diff(known)
    told = np.diff(commanded[known])
    if len(steps) < FEWEST or not np.isfinite(told).all():
        return angles
    sign = float(np.sign(np.sum(told * steps))) or 1.0
    excess = steps - sign * told
    excess -= np.median(excess / gaps) * gaps  # a log in wrong units of angle, or a slow drift
    spread = _spread(excess / np.sqrt(gaps))
    total = np.concatenate([[0.0], np.cumsum(excess)])
    scatter2 = max((_spread(total[FAR:] - total[:-FAR]) ** 2 - spread**2) / (FAR - 1), (LEAST * spread) ** 2)
    weight = tukey(excess / np.sqrt(gaps) / spread) / (scatter2 * gaps)
    # corrections c minimise sum (c / std)^2 + weight * (excess + difference of c)^2: a tridiagonal system
    n = len(known)
    D = np.zeros((n - 1, n))
    D[np.arange(n - 1), np.arange(n - 1)], D[np.arange(n - 1), np.arange(1, n)] = -1, 1
    std = np.maximum(angle_std[known], EXACT)
    noise = min(np.sqrt(max(spread**2 - scatter2, EXACT**2) / 2), float(np.median(std)))  # stated or seen, the smaller
    own = (np.median(std) / std / noise) ** 2
    change = np.linalg.solve(np.diag(own) + D.T @ (D * weight[:, None]), -D.T @ (weight * excess))
    out = angles.copy()
    out[known] += change
    return out - out[known[0]]


def _spread(values: Array) -> float:
    return max(1.4826 * float(np.median(np.abs(values - np.median(values)))), EXACT)
