"""Repeated values of some pixels: their standard deviation without outliers, and how well it is known."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.noise.memory import memory_of
from fusion.geometry.robust import MAD_TO_STD
from fusion.sensor.effects.readout.depth_quantization import rounded

Image = NDArray[np.floating]

FAR = 6.0  # robust standard deviations from its pixel's median: an outlier
GROUPS = 15  # pixels of like tilt are pooled, in this many groups at most and as many pixels at least
BATCHES = 20  # parts of a series whose scatter tells the error of its mean
SKIPPED = 1.5  # usual gaps between levels, from which on one between them was not seen
OCCUPIED = 8  # mean number of values per level below which levels may be missing


@dataclass(frozen=True)
class Repeats:
    """Values (frames, pixels) of some pixels, summed up."""

    sigma: float  # standard deviation of one value [m], what frames share included; NaN without values
    sigma_std: float  # how well it is known [m]
    # values less their pixel's mean, over their pixel's standard deviation; outliers are in it
    scores: NDArray[np.float32]
    step: float  # mean gap between neighbouring values that occur [m], 0 where it cannot be told


def repeats_of(values: Image, tilts: Image | None = None) -> Repeats:
    """Sum up values (frames, pixels) [m] that may hold NaN.

    Args:
        tilts: (pixels,) that the pixels look at [rad]: noise may grow steeply with it. The result is the mean of the
            standard deviations over the pixels, as laws are linear in terms of the tilt, and not the root of their
            mean square.
    """
    known = np.isfinite(values)
    several = known.sum(axis=0) > 1
    if not several.any():
        return Repeats(float("nan"), float("nan"), np.zeros(0, np.float32), 0.0)
    values = values[:, several].astype(float)
    tilts = np.zeros(values.shape[1]) if tilts is None else tilts[several]
    away = values - np.nanmedian(values, axis=0)
    step = _step(values, away)
    scale = MAD_TO_STD * float(np.nanmedian(np.abs(away)))
    # rounding can make the median distance 0 although the values scatter
    limit = FAR * max(scale, step) if max(scale, step) > 0 else np.inf
    kept = np.where(np.abs(away) <= limit, values, np.nan)
    count = np.isfinite(kept).sum(axis=0)
    kept, tilts, count = kept[:, count > 1], tilts[count > 1], count[count > 1]
    if not len(count):
        return Repeats(float("nan"), float("nan"), np.zeros(0, np.float32), step)
    mean = np.nanmean(kept, axis=0)
    squares = (kept - mean) ** 2 * (count / (count - 1))
    variance = float(np.nanmean(squares))
    independent = variance * np.sqrt(2.0 / (count - 1).sum())
    error = max(batch_error(squares), independent) / (2 * max(np.sqrt(variance), 1e-9))
    per_pixel = np.nanmean(squares, axis=0)
    groups = np.array_split(np.argsort(tilts, kind="stable"), min(GROUPS, -(-len(tilts) // GROUPS)))
    sigma = float(np.average([np.sqrt(per_pixel[g].mean()) for g in groups], weights=[len(g) for g in groups]))
    if step > sigma:  # what a pixel shows depends on its place between two levels more than on its tilt
        sigma = float(np.sqrt(variance))
    memory = memory_of(kept)
    sigma *= float(np.sqrt(memory.gain))
    error = max(float(np.sqrt(memory.gain)) * error, sigma * memory.error / 2)
    return Repeats(sigma, error, _scores(values), step)


def batch_error(squares: Image) -> float:
    """Standard error of the mean of (frames, places), frames taken as what is independent; places need not be.

    Frames are joined into batches, so that what lasts for a few frames counts too.
    """
    per_frame = np.nanmean(squares[np.isfinite(squares).any(axis=1)], axis=1)  # a frame without a value has no mean
    per_frame = per_frame[np.isfinite(per_frame)]
    parts = min(BATCHES, len(per_frame))
    if parts < 2:
        return 0.0
    means = np.array([part.mean() for part in np.array_split(per_frame, parts)])
    return float(means.std(ddof=1) / np.sqrt(parts))


def _step(values: Image, away: Image) -> float:
    """Mean gap between neighbouring values that single pixels take in the middle of their distribution [m]; 0 where
    levels are too rare. Not between those of all pixels, which a tilted target spreads over far more than its noise.
    """
    size = np.abs(away)
    moved = size[np.isfinite(size) & (size > 0)]
    if not moved.size:
        return 0.0
    # most values can be their pixel's median, and the levels beside it count
    near = size <= max(float(np.nanpercentile(size, 60)), 1.01 * float(np.median(moved)))
    # float values that never repeat have no levels
    if near.sum() < OCCUPIED * len(np.unique(values[near])):
        return 0.0
    ordered = np.sort(np.where(near, values, np.nan), axis=0)
    gaps = np.diff(ordered, axis=0)
    gaps = gaps[np.isfinite(gaps) & (gaps > 0)]
    # a level that no frame of a pixel shows makes a double gap
    return float(gaps[gaps < SKIPPED * np.median(gaps)].mean()) if gaps.size else 0.0


def _scores(values: Image) -> NDArray[np.float32]:
    """Values less their pixel's mean over its standard deviation; pixels that never change are left out."""
    spread = np.nanstd(values, axis=0, ddof=1)
    known = np.isfinite(spread) & (spread > 0)
    scores = (values[:, known] - np.nanmean(values[:, known], axis=0)) / spread[known]
    return scores[np.isfinite(scores)].astype(np.float32)


PHASES = 64  # places within a step
FINEST = 0.12  # steps: a smaller noise hardly ever changes a value
COUNTS_APART = 1.2  # levels this many counts apart or more are rounded to counts a second time


def without_rounding(
    sigma: float, sigma_std: float, step: float, span: float, places: float = np.inf
) -> tuple[float, float]:
    """Noise before the rounding [m] and how well it is known, from the scatter of rounded values.

    Args:
        sigma, sigma_std: of the rounded values [m].
        step: of the rounding [m].
        span: range of the true depths of the pixels that were pooled [m]: over many steps the phase averages out.
        places: number of different depths among them: as many phases at most.
    """
    if not (step > 0 and np.isfinite(sigma)):
        return sigma, sigma_std
    at, mean, scatter = _table()
    variance = (sigma / step) ** 2
    if variance >= mean[-1]:  # far above a step rounding is only more noise
        found, slope, unsure = float(np.sqrt(variance - 1 / 12)), 2 * float(np.sqrt(variance)), 0.0
    else:
        found = float(np.interp(variance, mean, at))
        slope = float(np.interp(found, at, np.gradient(mean, at)))
        unsure = float(np.interp(found, at, scatter)) / np.sqrt(min(1 + 2 * span / step, places))
    if found < FINEST:
        return found * step, FINEST * step
    spread = 2 * sigma * sigma_std / step**2  # of the variance
    return found * step, float(np.hypot(spread, unsure) / slope * step)


def whole_step(step: float, count: float) -> float:
    """One step for a sensor's levels [m] that were rounded to a file's counts [m] afterwards."""
    return float(np.hypot(step, count)) if step > COUNTS_APART * count else step


@lru_cache(maxsize=1)
def _table() -> tuple[NDArray[np.floating], NDArray[np.floating], NDArray[np.floating]]:
    """Standard deviation before the rounding [steps]; mean and scatter over the phases of the variance behind it."""
    at = np.linspace(0.02, 1.0, 99)
    phase = np.linspace(-0.5, 0.5, PHASES, endpoint=False)
    behind = rounded(phase[None, :], np.broadcast_to(at[:, None], (len(at), PHASES)))[1] ** 2
    mean, scatter = behind.mean(axis=1), behind.std(axis=1)
    at.flags.writeable = mean.flags.writeable = scatter.flags.writeable = False
    return at, mean, scatter
