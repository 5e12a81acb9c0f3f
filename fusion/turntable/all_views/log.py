"""What the table's log adds to measured angles: its steps are measurements too, as good as they prove to be."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.robust import robust_std, tukey

Array = NDArray[np.float64]
FEWEST = 24  # steps from which their scatter can be told
FAR = 8  # steps over which the table's scatter has added up
LEAST = 0.1  # share of the spread that is taken to be the table's in any case: 24 steps do not tell less (guess)
LEAST_SPREAD = np.deg2rad(0.5)  # of a step of a table: no log is taken for better (guess)
USUAL = 2.4  # spreads at which a step counts a quarter (Geman and McClure): slips are ten and more
KOLMOGOROV = 1.63  # standard deviations of the end of a random walk that its bridge hardly ever reaches: 1 in 100
EXACT = 1e-5  # [rad] smallest standard deviation


def log_equations(angles: Array, told: Array) -> tuple[NDArray[np.intp], Array, Array]:
    """What a log says of the steps between the frames that are known.

    Its spread is what the steps differ from it by, robustly and about zero: a log is no better than it proves to be.
    Beyond that the weight falls with the fourth power: a slip is not pulled back, and yet can be.

    Args:
        angles: (n,) so far [rad], NaN where a frame is left out.
        told: (n,) by the log [rad], of the same sign.

    Returns:
        The known frames (k,), and of each step between them (k - 1,) its weight [1 / rad^2] and its turn beyond the
        log [rad].
    """
    known = np.flatnonzero(np.isfinite(angles) & np.isfinite(told))
    excess, gaps = np.diff(angles[known]) - np.diff(told[known]), np.diff(known)
    each = excess / np.sqrt(gaps)
    spread = max(robust_std(each), LEAST_SPREAD) if len(each) else LEAST_SPREAD
    return known, 1 / (spread**2 * gaps * (1 + (each / (USUAL * spread)) ** 2) ** 2), excess


def of_its_sign(angles: Array, told: Array) -> Array:
    """Told angles (n,) [rad] with the sign of the turns that were found, 0 at the first known frame."""
    known = np.flatnonzero(np.isfinite(angles) & np.isfinite(told))
    sign = float(np.sign(np.sum(np.diff(told[known]) * np.diff(angles[known])))) or 1.0
    return np.asarray(sign * (told - told[known[0]]) if len(known) else told)


def departure(angles: Array, told: Array, slips: Sequence[int] = ()) -> tuple[float, float]:
    """How far angles leave their log smoothly, and how far steps as uneven as these may lead by chance [rad].

    Steps that err independently add up to a random walk; between its fixed ends it leaves the straight line by more
    than 1.63 standard deviations of its end in one of 100 tables (Kolmogorov 1933). Errors that stand still in the
    image, or a wrong log, bend the angles far more than their single steps scatter. The straight line itself is the
    unit of the log, which scan/judging/table_lights.py judges.

    Args:
        angles: (n,) measured [rad], NaN where rejected.
        told: (n,) by the log [rad], of either sign.
        slips: frames before which the object slipped; these steps say nothing.
    """
    known = np.flatnonzero(np.isfinite(angles) & np.isfinite(told))
    if len(known) < FEWEST:
        return 0.0, np.inf
    excess = np.diff(angles[known]) - np.diff(of_its_sign(angles, told)[known])
    gone = np.isin(known[1:], slips)
    excess -= np.median(excess[~gone])
    excess[gone] = 0.0
    path = np.concatenate([[0.0], np.cumsum(excess)])
    path -= np.linspace(0, 1, len(path)) * path[-1]
    own = _spread(np.diff(excess[~gone])) / np.sqrt(2)  # what is smooth is no scatter of single steps
    return float(np.abs(path).max()), KOLMOGOROV * own * float(np.sqrt(len(excess)))


def with_log(angles: Array, angle_std: Array, commanded: Array) -> Array:
    """Angles (n,) [rad] as the surface and the log together say them, 0 at the first.

    The table's own scatter is what its steps differ from the log by beyond the noise of the measurement, and no less
    than what adds up over several steps, as slow errors of the measurement do. (Steps that err about a place, as those
    of most tables, do not add up: that alone would take them for noise and pull the angles to the log.) Steps that do
    not fit (slips) take no part, so each stretch between them moves freely.

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
    added_up = (_spread(total[FAR:] - total[:-FAR]) ** 2 - spread**2) / (FAR - 1)
    std = np.maximum(angle_std[known], EXACT)
    beyond = spread**2 - 2 * float(np.median(std)) ** 2  # a step has the noise of two angles
    scatter2 = max(added_up, beyond, (LEAST * spread) ** 2)
    weight = tukey(excess / np.sqrt(gaps) / spread) / (scatter2 * gaps)
    # corrections c minimise sum (c / std)^2 + weight * (excess + difference of c)^2: a tridiagonal system
    n = len(known)
    D = np.zeros((n - 1, n))
    D[np.arange(n - 1), np.arange(n - 1)], D[np.arange(n - 1), np.arange(1, n)] = -1, 1
    noise = min(np.sqrt(max(spread**2 - scatter2, EXACT**2) / 2), float(np.median(std)))  # stated or seen, the smaller
    own = (np.median(std) / std / noise) ** 2
    change = np.linalg.solve(np.diag(own) + D.T @ (D * weight[:, None]), -D.T @ (weight * excess))
    out = angles.copy()
    out[known] += change
    return out - out[known[0]]


def _spread(values: Array) -> float:
    return max(robust_std(values - np.median(values)), EXACT)
