"""Turning: the values of parameters that explain the scatter best, and how much better than others."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from fusion.calibration.reach import reach
from fusion.discrepancy.channels.noise_parameters import NoiseParameter
from fusion.discrepancy.channels.scatter import Scatter
from fusion.geometry.robust import robust_std

Vector = NDArray[np.float64]

COMMON = 0.02  # of the variance of a whole recording: what the model leaves open at least
OUTLIER = 3.0  # standard deviations from which on a tile counts less
WITHOUT_SLOPE = 2.0  # times as far as its reach, a number's slope alone would let it go: the slope says nothing
FIRST = 1e-3  # of its usual size: first step away from a number without a slope
LEAST_GROWTH = -0.95  # of a variance: noise does not vanish


@dataclass(frozen=True)
class TunedParameters:
    """Noise parameters at their best values."""

    params: tuple[NoiseParameter, ...]  # all that were turned
    # values, std: (k,) of them
    values: Vector
    std: Vector
    chi2: float  # of the tiles, with what the values cost that leave what is known of them

    def excess(self) -> Vector:
        """(n,) change of the logarithm of the variance."""
        return changes(self.params, self.values)[0]

    def renewal(self) -> Vector:
        return changes(self.params, self.values)[1]


@dataclass(frozen=True)
class Whitener:
    """What residuals of the scatter are measured with."""

    # standard deviation of an error that all tiles of a recording share, of the logarithm of the variance
    common: float = COMMON
    inflated: float = 1.0  # factor of all standard deviations

    def white(self, scatter: Scatter, excess: Vector, renewal: Vector) -> Vector:
        """(2 n,) residuals as independent numbers of unit spread."""
        parts = []
        for values, sigma in ((excess, scatter.excess_sigma), (renewal, scatter.renewal_sigma)):
            parts.append(self._white(values, 1.0 / (sigma * self.inflated), scatter.place))
        return np.concatenate(parts)

    def _white(self, values: Vector, weight: Vector, place: NDArray[np.intp]) -> Vector:
        out = values * weight
        for g in np.unique(place):
            rows = place == g
            length = float(np.linalg.norm(weight[rows]))
            if length > 0:
                along = weight[rows] / length
                shrunk = 1.0 - 1.0 / np.sqrt(1.0 + (self.common * length) ** 2)
                out[rows] -= shrunk * along * float(along @ out[rows])
        return out


def changes(params: Sequence[NoiseParameter], values: Sequence[float] | Vector) -> tuple[Vector, Vector]:
    """(n,) changes of the logarithm of the variance, and of its new share."""
    growth, factor, renewal = np.zeros(1), np.zeros(1), np.zeros(1)
    for param, value in zip(params, values, strict=True):
        parts = param.turned(float(value))
        growth, factor, renewal = growth + parts[0], factor + parts[1], renewal + parts[2]
    return np.log1p(np.maximum(growth, LEAST_GROWTH)) + factor, renewal


def turn(
    scatter: Scatter, whitener: Whitener, params: Sequence[NoiseParameter], start: Sequence[float] | Vector
) -> TunedParameters:
    """The best values of parameters; those that are known cost what they leave of it."""
    if not params:
        return TunedParameters(
            (), np.zeros(0), np.zeros(0), _chi2(whitener.white(scatter, scatter.excess, scatter.renewal))
        )
    scale = np.array([_scale(k, s) for k, s in zip(params, start, strict=True)])
    prior = np.array([0.0 if k.new else _scale(k, s) / k.sigma for k, s in zip(params, start, strict=True)])
    centre = np.array([k.value for k in params]) / scale

    def misfit(x: Vector) -> Vector:
        excess, renewal = changes(params, x * scale)
        white = whitener.white(scatter, scatter.excess - excess, scatter.renewal - renewal)
        return np.concatenate([_tamed(white), (x - centre) * prior])

    low = np.array([k.parameter.low for k in params]) / scale
    high = np.array([k.parameter.high for k in params]) / scale
    inside = np.clip(np.array(start) / scale, low + 1e-9, high - 1e-9)
    found = least_squares(misfit, inside, bounds=(low, high), x_scale=1.0, max_nfev=40)
    room = np.maximum(high - found.x, 0.0)
    std = _deviations(misfit, found.x, found.jac, room) * scale
    return TunedParameters(tuple(params), found.x * scale, std, float(2 * found.cost))


def _deviations(misfit: Callable[[Vector], Vector], at: Vector, jac: NDArray[np.float64], room: Vector) -> Vector:
    """(k,) standard deviations; of a number without a slope, as one whose square came to 0, what the data allow."""
    lowest = float(np.sum(misfit(at) ** 2))
    alone = 1.0 / np.maximum(np.linalg.norm(jac, axis=0), 1e-300)
    reached = np.full(len(at), np.inf)
    for i in np.flatnonzero(alone > np.abs(at)):  # a larger number is told by its slope
        unit = np.eye(len(at))[i]

        def cost(by: float, unit: Vector = unit) -> float:
            return float(np.sum(misfit(at + by * unit) ** 2)) - lowest

        reached[i] = reach(cost, float(room[i]), FIRST)
    held = alone > WITHOUT_SLOPE * reached
    out = np.where(held, reached, 0.0)
    covariance = np.linalg.pinv(jac[:, ~held].T @ jac[:, ~held])
    out[~held] = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return out


def as_stated(scatter: Scatter, whitener: Whitener, params: Sequence[NoiseParameter]) -> TunedParameters:
    """Noise parameters that nobody turned."""
    return TunedParameters(
        tuple(params),
        np.array([param.value for param in params]),
        np.array([param.sigma for param in params]),
        _chi2(whitener.white(scatter, scatter.excess, scatter.renewal)),
    )


def whitener_of(scatter: Scatter, best: TunedParameters | None) -> Whitener:
    """The whitener under which what the best explanation leaves is noise: whole recordings first, then tiles."""
    excess = scatter.excess - (best.excess() if best and best.params else 0.0)
    offsets, noise, spread = [], [], []
    for g in np.unique(scatter.place):
        rows = scatter.place == g
        weight = 1 / scatter.excess_sigma[rows] ** 2
        offset = float(np.average(excess[rows], weights=weight))
        offsets.append(offset)
        noise.append(1 / float(weight.sum()))
        spread.append((excess[rows] - offset) / scatter.excess_sigma[rows])
    between = float(robust_std(np.asarray(offsets)) ** 2 - np.median(noise)) if len(offsets) > 2 else 0.0
    inflated = robust_std(np.concatenate(spread))
    return Whitener(float(np.sqrt(max(between, COMMON**2))), max(1.0, inflated))


def _tamed(white: Vector) -> Vector:
    """Residuals whose squares grow only linearly beyond OUTLIER (Huber)."""
    size = np.abs(white)
    far = size > OUTLIER
    return np.where(far, np.sign(white) * np.sqrt(np.maximum(2 * OUTLIER * size - OUTLIER**2, 0.0)), white)


def _chi2(white: Vector) -> float:
    return float((_tamed(white) ** 2).sum())


def _scale(param: NoiseParameter, start: float) -> float:
    size = max(abs(start), abs(param.value))
    return size if size > 0 else (param.parameter.typical if param.new else param.sigma)
