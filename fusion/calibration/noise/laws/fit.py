"""Fitting a law to noise measured at many poses; the poses, not the pixels, count as measurements."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.special import stdtrit

from fusion.calibration.reach import reach

Array = NDArray[np.floating]

FOLDS = 10
ROUNDS = 6  # of weights and scatter; they settle within four
LEAST_SCATTER = 0.01  # share: held-out errors below this tell laws apart no better
AT_BOUND = 1e-9  # nearer than this to its lowest a number is there
WITHOUT_SLOPE = 2.0  # times as far as its reach, a number's slope alone would let it go: the slope says nothing
SMALLEST = 1e-12  # laws stay positive where they are compared


class NoiseForm(Protocol):
    """A law with free numbers."""

    @property
    def title(self) -> str:
        """For a person."""

    @property
    def names(self) -> tuple[str, ...]:
        """Of the numbers."""

    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest numbers."""

    def start(self, values: Array) -> Array:
        """Numbers to begin with."""

    def predict(self, numbers: Array) -> Array:
        """(n,) values at the places where it was measured."""

    def part(self, which: NDArray[np.bool_]) -> Self:
        """The same law at some of the places."""


@dataclass(frozen=True)
class Data:
    """Measured values (n,) with their standard deviations; `relative`: those grow with the true value."""

    value: Array
    std: Array
    relative: bool = True

    def part(self, which: NDArray[np.bool_]) -> "Data":
        """Some of them."""
        return Data(self.value[which], self.std[which], self.relative)

    def error(self, about: Array) -> Array:
        """(n,) deviations where the law says `about`.

        Where they grow with the value they follow the law: else a value that is low by chance would count more.
        """
        if not self.relative:
            return self.std
        return np.maximum(self.std / np.maximum(self.value, SMALLEST), 1e-4) * about


@dataclass(frozen=True)
class NoiseFit:
    """A law with its numbers."""

    form: NoiseForm  # the law
    numbers: Array  # (k,) in the order of its names
    covariance: Array  # (k, k), from the measurements' errors and the scatter between poses
    freedom: int  # poses less numbers
    scatter: float  # share of the value by which poses scatter beyond their measurements' errors
    rms: float  # of measured less fitted values
    # (n,) measured less predicted, each by a fit without it, over the expected error; NaN where that was not possible
    heldout: Array

    @property
    def std(self) -> Array:
        """(k,) standard deviations of the numbers."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def correlation(self) -> Array:
        """(k, k)."""
        scale = np.maximum(self.std, 1e-300)
        return np.asarray(self.covariance / np.outer(scale, scale))

    def half_width(self, level: float = 0.9) -> float:
        """Standard deviations that an interval of this level reaches to either side."""
        return float(stdtrit(max(self.freedom, 1), 0.5 + level / 2))

    def predict_with_std(self, form: NoiseForm) -> tuple[Array, Array]:
        """The law at other places (a form of the same names) and its standard deviation."""
        slopes = _slopes(form.predict, self.numbers, self.std)
        return form.predict(self.numbers), np.sqrt(np.einsum("ni,ij,nj->n", slopes, self.covariance, slopes))

    @property
    def score(self) -> float:
        """Root mean square of the held-out errors, 1 where the law leaves nothing but the measurements' own."""
        known = self.heldout[np.isfinite(self.heldout)]
        return float(np.sqrt(np.mean(known**2))) if len(known) else float("inf")


def fit_law(form: NoiseForm, data: Data) -> NoiseFit:
    """Fit a law to measured values, and judge it on held-out poses."""
    numbers, scatter = _solve(form, data)
    value = np.maximum(form.predict(numbers), SMALLEST)
    weight = 1.0 / (data.error(value) ** 2 + (scatter * value) ** 2)
    covariance = _covariance(form, numbers, weight)
    rms = float(np.sqrt(np.mean((data.value - form.predict(numbers)) ** 2)))
    return NoiseFit(
        form, numbers, covariance, len(data.value) - len(numbers), scatter, rms, _held_out(form, data, scatter)
    )


def choose(fits: Sequence[NoiseFit]) -> int:
    """Index of the simplest law that is as good on held-out poses as the best, within one standard error."""
    best = min(range(len(fits)), key=lambda i: fits[i].score)
    order = sorted(range(len(fits)), key=lambda i: (len(fits[i].numbers), fits[i].score))
    for i in order:
        worse = fits[i].heldout ** 2 - fits[best].heldout ** 2
        worse = worse[np.isfinite(worse)]
        if i == best or (len(worse) and worse.mean() <= worse.std() / np.sqrt(len(worse))):
            return i
    return best


def _solve(form: NoiseForm, data: Data, scatter: float | None = None) -> tuple[Array, float]:
    """Numbers, and the scatter (share) between poses, found unless it is given."""
    extra, about = scatter or 0.0, np.maximum(data.value, SMALLEST)
    low, high = form.bounds()
    numbers = np.clip(form.start(data.value), low, high)
    for _ in range(ROUNDS):
        error = np.hypot(data.error(about), extra * about)
        numbers = least_squares(_misfit, numbers, bounds=(low, high), x_scale="jac", args=(form, data, error)).x
        about = np.maximum(form.predict(numbers), SMALLEST)
        if scatter is None:
            extra = _scatter((data.value - about) / about, data.error(about) / about, len(about) - len(numbers))
    return numbers, extra


def _misfit(numbers: Array, form: NoiseForm, data: Data, error: Array) -> Array:
    return np.asarray((form.predict(numbers) - data.value) / error)


def _scatter(off: Array, share: Array, freedom: int) -> float:
    """The scatter that makes the weighted square of what is left over that of its freedom; 0 where it is less."""
    if freedom <= 0 or (off**2 / share**2).sum() <= freedom:
        return 0.0
    low, high = 0.0, 1.0 + float(np.abs(off).max()) * np.sqrt(len(off))
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if (off**2 / (share**2 + middle**2)).sum() > freedom else (low, middle)
    return high


def _held_out(form: NoiseForm, data: Data, scatter: float) -> Array:
    """(n,) measured less predicted by fits to the other folds, over the expected error."""
    n = len(data.value)
    out = np.full(n, np.nan)
    if n <= len(form.names) + 1:
        return out
    for fold in range(min(FOLDS, n)):
        left = np.arange(n) % min(FOLDS, n) == fold
        numbers, _ = _solve(form.part(~left), data.part(~left), scatter)
        value = np.maximum(form.part(left).predict(numbers), SMALLEST)
        measured = data.part(left)
        # the measurement's own error, not the law's: the same for all laws
        expected = np.hypot(measured.error(np.maximum(measured.value, SMALLEST)), LEAST_SCATTER * measured.value)
        out[left] = (measured.value - value) / expected
    return out


def _covariance(form: NoiseForm, numbers: Array, weight: Array) -> Array:
    """(k, k); numbers at their lowest are held, and may be as far from it as the measurements allow.

    So are numbers without a slope: the square of one that is 0 has none, nor has one that has no part in the law.
    """
    covariance = np.zeros((len(numbers), len(numbers)))
    every = _slopes(form.predict, numbers, np.abs(numbers))
    alone = 1.0 / np.sqrt(np.maximum((every**2 * weight[:, None]).sum(axis=0), 1e-300))
    reached = [_reach(form, numbers, i, weight) for i in range(len(numbers))]
    held = (numbers <= form.bounds()[0] + AT_BOUND) | (alone > WITHOUT_SLOPE * np.array(reached))
    slopes = every[:, ~held]
    scale = np.sqrt(np.maximum((slopes**2 * weight[:, None]).sum(axis=0), 1e-300))  # numbers differ in unit
    information = (slopes / scale).T @ (slopes / scale * weight[:, None])
    inverse = np.linalg.pinv(information, rcond=1e-12, hermitian=True) / np.outer(scale, scale)
    covariance[np.ix_(~held, ~held)] = inverse
    covariance[held, held] = np.square(np.array(reached)[held])
    return covariance


def _reach(form: NoiseForm, numbers: Array, which: int, weight: Array) -> float:
    """How far a number moves until chi2 has grown by 1, or it is at its highest."""
    value, moved = form.predict(numbers), numbers.copy()

    def cost(by: float) -> float:
        moved[which] = numbers[which] + by
        return float((weight * (form.predict(moved) - value) ** 2).sum())

    return reach(cost, float(form.bounds()[1][which] - numbers[which]))


def _slopes(predict: Callable[[Array], Array], numbers: Array, sizes: Array) -> Array:
    """(n, k) derivative of a law by its numbers, by central differences."""
    columns = []
    for i in range(len(numbers)):
        step = np.zeros(len(numbers))
        step[i] = 1e-4 * max(sizes[i], 1e-6)
        columns.append((predict(numbers + step) - predict(numbers - step)) / (2 * step[i]))
    return np.stack(columns, axis=1)
