"""Repeatability and reproducibility as ISO 5725-2:2019 defines them, over the whole surface.

A place of the surface is a level, a scan a result, a condition (another day, camera, operator) a laboratory: variances
of all places are pooled. r = 2.8 s_r is what two scans differ by in 5 % of the cases (ISO 5725-6, 4.1.4).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
LIMIT = 2.8  # 1.96 * sqrt(2)


@dataclass(frozen=True)
class Repeatability:
    """Scans under one condition."""

    s: float  # repeatability standard deviation s_r [m]; what lies in the pose of a scan is not in it
    s_std: float  # standard deviation of that, from leaving out one scan after the other; NaN with two scans
    p95: float  # 95 % of the places spread by less [m]
    shown_by_all: float  # share of the surface that every scan shows

    def values(self) -> dict[str, float]:
        """For JSON."""
        told = {"s_r_m": self.s, "s_r_std_m": self.s_std, "limit_r_m": LIMIT * self.s}
        return told | {"spread_p95_m": self.p95, "shown_by_all_share": self.shown_by_all}


@dataclass(frozen=True)
class Reproducibility:
    """Scans under several conditions: between them `between` (s_L), all together `s` (s_R), in metres."""

    s: float
    between: float
    conditions: int

    def values(self) -> dict[str, float]:
        """For JSON."""
        told = {"s_R_m": self.s, "s_L_m": self.between, "limit_R_m": LIMIT * self.s}
        return told | {"conditions": self.conditions}


def repeatability(offsets: Array, condition: NDArray[np.intp]) -> Repeatability:
    """Of offsets (m, n) [m], NaN where a scan has nothing, and the condition (n,) of each scan."""
    squares, free = _within(offsets, condition)
    s = _pooled(squares, free)
    known = free > 0
    places = np.sqrt(squares[known] / free[known])
    some = np.isfinite(offsets)
    n = offsets.shape[1]
    std = float("nan")
    if n > 2:
        less = [_pooled(*_within(np.delete(offsets, k, axis=1), np.delete(condition, k))) for k in range(n)]
        std = float(np.sqrt((n - 1) / n * np.sum((np.array(less) - np.mean(less)) ** 2)))
    p95 = float(np.percentile(places, 95)) if len(places) else float("nan")
    return Repeatability(s, std, p95, float(some.all(axis=1).mean()))


def reproducibility(offsets: Array, condition: NDArray[np.intp]) -> Reproducibility | None:
    """None where all scans were taken under one condition."""
    names = np.unique(condition)
    if len(names) < 2:
        return None
    squares, free = _within(offsets, condition)
    within = squares.sum() / max(float(free.sum()), 1.0)
    groups = [offsets[:, condition == name] for name in names]
    means = np.column_stack([_mean(group) for group in groups])
    counts = np.column_stack([np.isfinite(group).sum(axis=1) for group in groups])
    whole = np.isfinite(means).all(axis=1)
    if not whole.any():
        return Reproducibility(float("nan"), float("nan"), len(names))
    means, counts = means[whole], counts[whole]
    # the variance between means of conditions holds that within, over the scans of each
    between = np.var(means, axis=1, ddof=1).mean() - within * np.mean(1 / counts)
    s_L = float(np.sqrt(max(float(between), 0.0)))
    return Reproducibility(float(np.sqrt(within + s_L**2)), s_L, len(names))


def _within(offsets: Array, condition: NDArray[np.intp]) -> tuple[Array, Array]:
    """Sums of squares about the mean of each condition (m,), and their degrees of freedom (m,)."""
    squares, free = np.zeros((2, len(offsets)))
    for name in np.unique(condition):
        group = offsets[:, condition == name]
        known = np.isfinite(group)
        squares += np.where(known, (group - np.nan_to_num(_mean(group))[:, None]) ** 2, 0).sum(axis=1)
        free += np.maximum(known.sum(axis=1) - 1, 0)
    return squares, free


def _mean(group: Array) -> Array:
    known = np.isfinite(group)
    count = known.sum(axis=1)
    return np.where(count > 0, np.where(known, group, 0).sum(axis=1) / np.maximum(count, 1), np.nan)


def _pooled(squares: Array, free: Array) -> float:
    return float(np.sqrt(squares.sum() / free.sum())) if free.sum() else float("nan")
