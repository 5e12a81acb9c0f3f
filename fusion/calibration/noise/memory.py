"""Noise that frames share with those before them: a temporal filter makes the scatter over time too small.

The mean square of the differences between frames k apart is free of that (the variogram, Matheron 1963). A filter that
mixes each frame with the one before leaves `white + filtered (1 - exp(-k / tau))` of it, and what it tends to is the
variance of one value, also where the recording is too short for the scatter about a mean to reach it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

Array = NDArray[np.floating]

LAGS = 24  # distances between frames, at most
TIMES = 24  # memories tried, from a third of a frame to the whole recording
PARTS = 8  # of the pixels, whose scatter tells how well the gain is known
FEWEST = 8  # frames: of fewer the memory cannot be told
SURE = 4.0  # standard deviations by which there must be a memory at all


class Memory(NamedTuple):
    """What the scatter over time misses."""

    gain: float = 1.0  # variance of one value over the scatter of the frames (with n - 1); 1 where nothing is shared
    error: float = 0.0  # standard deviation of that variance of one value, as a share of it; 0 without a memory


def memory_of(values: Array) -> Memory:
    """The memory of values (frames, pixels) that may hold NaN; what all pixels share is no filter's and left out."""
    if len(values) < FEWEST or values.shape[1] < 2 * PARTS:
        return Memory()
    known = np.isfinite(values)
    shared = np.where(known, values, 0).sum(axis=1) / np.maximum(known.sum(axis=1), 1)
    own = values - shared[:, None]
    parts = np.array([_variances(part) for part in np.array_split(own, PARTS, axis=1)])
    whole, scatter, next_one = parts.T
    if not (scatter > 0).all():
        return Memory()
    alike = 1 - next_one / scatter  # 0 of frames that share nothing, however long the recording
    if alike.mean() <= SURE * alike.std(ddof=1) / np.sqrt(PARTS):
        return Memory()
    gain = float(whole.mean() / scatter.mean())
    return Memory(max(gain, 1.0), float(whole.std(ddof=1) / whole.mean() / np.sqrt(PARTS)))


def _variances(own: Array) -> tuple[float, float, float]:
    """Of one value, as differences tell it; of the frames about their mean (with n - 1); half of that of steps."""
    n = len(own)
    lags = np.unique(np.rint(np.geomspace(1, n - 1, LAGS)).astype(int))
    apart, pairs = np.empty(len(lags)), np.empty(len(lags))
    for i, k in enumerate(lags):
        square = (own[k:] - own[:-k]) ** 2
        known = np.isfinite(square)
        pairs[i] = known.sum()
        apart[i] = 0.5 * square[known].sum() / max(pairs[i], 1)
    weight = np.sqrt(pairs)
    several = np.isfinite(own).sum(axis=0) > 1
    scatter = float(np.mean(np.nanvar(own[:, several], axis=0, ddof=1))) if several.any() else 0.0
    fits = []
    for tau in np.geomspace(0.3, n, TIMES):
        columns = np.column_stack([np.ones(len(lags)), 1 - np.exp(-lags / tau)])
        size, rest = nnls(columns * weight[:, None], apart * weight)
        fits.append((rest, float(size.sum())))
    return min(fits)[1], scatter, float(apart[0])
