"""The quantisation step over distance, from the depths that occur at all: a single frame is enough."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.robust import robust_std

NEIGHBOURS = 12  # levels in a row that give one step
PER_LEVEL = 4.0  # pixels a level needs on average: fewer leave levels out by chance
MOST_STEPS = 3  # in one gap: beyond a larger one the levels may be others
RARE = 0.1  # share of the usual count of the levels around: rarer ones are mixtures, not levels
FEWEST_GAPS = 3  # between levels, for one step
FEWEST = 5  # windows that a law needs
LEVEL = 1.645  # standard deviations of a 90 % interval

Array = NDArray[np.floating]


@dataclass(frozen=True)
class Quantization:
    """Steps between neighbouring depths."""

    depth: Array  # (k,) middle of each window of levels [m]
    step: Array  # (k,) [m]
    unit: float  # one count of the file [m]
    law: str  # "z^2", "constant", "file" (every count occurs: the sensor's own step is not larger) or "unknown"
    value: float  # step at 1 m [m] for "z^2", the step [m] otherwise; NaN when unknown
    interval: tuple[float, float]  # 90 % of it [m]
    # exponent, exponent_std: of distance in the step
    exponent: float
    exponent_std: float

    def at(self, depth: Array) -> Array:
        """Step of the law [m]."""
        return self.value * (np.square(depth) if self.law == "z^2" else np.ones_like(depth))


def quantization_of(views: Sequence[NDArray[np.int64]], depth_scale: float) -> Quantization | None:
    """Steps of the depths that occur.

    Args:
        views: how often each count of the file occurs, per view: walls at several distances share no levels.
    Returns: None where too little occurs.
    """
    found = np.array([step for counts in views for step in _steps(counts)]).reshape(-1, 2) / depth_scale
    if not len(found):
        return None
    middle, step = found[np.argsort(found[:, 0])].T
    return _law(middle, step, 1.0 / depth_scale)


def coarseness(counts: NDArray[np.int64]) -> float:
    """The usual gap between neighbouring depths that occur [count], each weighed by its values; 0 below two of them."""
    levels = np.flatnonzero(counts[:65535])
    levels = levels[levels > 0]
    if not len(levels):
        return 0.0
    weight = counts[levels]
    levels = levels[weight >= RARE * _weighed_median(weight, weight)]  # rarer ones are mixtures
    if len(levels) < 2:
        return 0.0
    gaps = np.diff(levels)
    # what lies between two surfaces is no gap of either
    nearer = np.minimum(np.append(gaps, gaps[-1]), np.insert(gaps, 0, gaps[0]))
    return _weighed_median(nearer, counts[levels])


def _weighed_median(values: NDArray[np.int64], weight: NDArray[np.int64]) -> float:
    order = np.argsort(values, kind="stable")
    up_to = np.cumsum(weight[order])
    return float(values[order][np.searchsorted(up_to, up_to[-1] / 2)])


def _steps(counts: NDArray[np.int64]) -> Iterator[tuple[float, float]]:
    """Middle and step [count] of every window of neighbouring levels."""
    levels = np.flatnonzero(counts)
    levels = levels[(levels > 0) & (levels < 65535)]
    if len(levels) <= FEWEST_GAPS:
        return
    weight = counts[levels].astype(float)
    for start in range(0, max(len(levels) - NEIGHBOURS, 1), NEIGHBOURS // 2):
        window = slice(start, start + NEIGHBOURS + 1)
        found = _step(levels[window].astype(float), weight[window])
        if found:
            yield found


def _step(levels: Array, weight: Array) -> tuple[float, float] | None:
    """Middle and step of neighbouring levels [count]; None where chance leaves too many out."""
    if weight.mean() < PER_LEVEL:
        return None
    kept = weight >= RARE * np.median(weight)
    levels = levels[kept]
    if len(levels) <= FEWEST_GAPS:
        return None
    step = _even(levels, np.ones(len(levels) - 1))
    if step is not None:
        return float(0.5 * (levels[0] + levels[-1])), step
    # coarse steps of a disparity grow within a window as they do beyond it
    step = _even(-1.0 / levels, 1.0 / (levels[1:] * levels[:-1]))
    return None if step is None else (float(np.sqrt(levels[0] * levels[-1])), step * levels[0] * levels[-1])


def _even(levels: Array, count: Array) -> float | None:
    """Step of levels (n,) that are evenly spaced but for a count (n - 1,) of the file; None of others."""
    gaps = np.diff(levels)
    usual = float(np.median(gaps))
    # a gap of two steps is a level that did not occur; counts round a step of 2.6 to 2 or 3
    steps = np.maximum(np.rint(gaps / usual), 1.0)
    uneven = np.abs(gaps - steps * usual) > np.maximum(0.2 * steps * usual, 1.01 * count)
    if uneven.any() or (steps > MOST_STEPS).any() or (steps > 1).mean() > 0.3:
        return None
    return float(gaps.sum() / steps.sum())


def _law(depth: Array, step: Array, unit: float) -> Quantization:
    """Which law holds, by the exponent of the distance."""
    nothing = float("nan")
    if float(np.median(step)) <= 1.1 * unit:
        return Quantization(depth, step, unit, "file", unit, (0.0, unit), nothing, nothing)
    # what is coarser than the file's unit tells the law
    told = step > 1.5 * unit
    z, s = depth[told], step[told]
    if len(z) < FEWEST or np.max(z) < 1.1 * np.min(z):
        value = float(np.median(step))
        return Quantization(
            depth, step, unit, "unknown", value, (float(np.min(step)), float(np.max(step))), nothing, nothing
        )
    exponent, deviation = _exponent(np.log(z), np.log(s))
    law = "z^2" if abs(exponent - 2) < abs(exponent) else "constant"
    if min(abs(exponent - 2), abs(exponent)) > max(0.25, 3 * deviation):
        law = "unknown"
    ratio = s / z**2 if law == "z^2" else s
    value = float(np.median(ratio))
    # windows overlap by half, and a window's ends are rounded to the file's unit
    rounding = float(np.median(unit / NEIGHBOURS / s))
    scatter = robust_std(ratio / value - 1) / np.sqrt(len(z) / 2)
    error = value * float(np.hypot(scatter, rounding))
    interval = (value - LEVEL * error, value + LEVEL * error)
    return Quantization(depth, step, unit, law, value, interval, exponent, deviation)


def _exponent(x: Array, y: Array) -> tuple[float, float]:
    """Slope of y over x and its standard deviation, windows that stand out left out."""
    keep = np.ones(len(x), bool)
    for _ in range(3):
        A = np.column_stack([np.ones(keep.sum()), x[keep]])
        c = np.linalg.lstsq(A, y[keep], rcond=None)[0]
        rest = y - c[0] - c[1] * x
        spread = robust_std(rest[keep]) + 1e-9
        keep = np.abs(rest) < 4 * spread + 0.02
    variance = float((rest[keep] ** 2).sum()) / max(int(keep.sum()) - 2, 1)
    # overlapping windows: half of them count
    return float(c[1]), float(np.sqrt(2 * variance / ((x[keep] - x[keep].mean()) ** 2).sum()))
