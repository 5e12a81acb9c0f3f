"""Fitting a law to standard deviations measured at many poses; the poses, not the pixels, count as measurements."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import t as student

Array = NDArray[np.floating]

FOLDS = 10
ROUNDS = 8  # of weights and scatter; they settle within four
LEAST_SCATTER = 0.01  # share: held-out errors below this tell laws apart no better
SMALLEST = 1e-7  # [m] laws stay positive where they are compared


class Form(Protocol):
    """A law with free numbers."""

    @property
    def names(self) -> tuple[str, ...]:
        """Of the numbers."""

    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest numbers."""

    def start(self, sigma: Array) -> Array:
        """Numbers to begin with."""

    def predict(self, numbers: Array) -> Array:
        """(n,) standard deviations [m] at the places where it was measured."""

    def part(self, which: NDArray[np.bool_]) -> "Form":
        """The same law at some of the places."""


@dataclass(frozen=True)
class Fit:
    """A law with its numbers.

    Attributes:
        form: the law.
        numbers: (k,) in the order of its names.
        covariance: (k, k), from the measurements' errors and the scatter between poses.
        freedom: poses less numbers.
        scatter: share of the noise by which poses scatter beyond their measurements' errors.
        rms: of measured less fitted [m].
        heldout: (n,) logarithm of measured over predicted, each by a fit without it, over its expected error; NaN
            where that was not possible.
    """

    form: Form
    numbers: Array
    covariance: Array
    freedom: int
    scatter: float
    rms: float
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
        return float(student.ppf(0.5 + level / 2, max(self.freedom, 1)))

    def predict_with_std(self, form: Form) -> tuple[Array, Array]:
        """The law at other places (a form of the same names) and its standard deviation [m]."""
        value = form.predict(self.numbers)
        slopes = _slopes(form.predict, self.numbers, self.std)
        return value, np.sqrt(np.einsum("ni,ij,nj->n", slopes, self.covariance, slopes))

    @property
    def score(self) -> float:
        """Root mean square of the held-out errors, 1 where the law leaves nothing but the measurements' own."""
        known = self.heldout[np.isfinite(self.heldout)]
        return float(np.sqrt(np.mean(known**2))) if len(known) else float("inf")


def fit_law(form: Form, sigma: Array, sigma_std: Array) -> Fit:
    """Fit a law to (n,) standard deviations [m] that are known to `sigma_std` [m], and judge it on held-out poses."""
    share = np.maximum(sigma_std / np.maximum(sigma, SMALLEST), 1e-4)
    numbers, scatter = _solve(form, sigma, share)
    value = np.maximum(form.predict(numbers), SMALLEST)
    weight = 1.0 / ((share**2 + scatter**2) * value**2)
    slopes = _slopes(form.predict, numbers, np.abs(numbers))
    covariance = np.linalg.pinv(slopes.T @ (slopes * weight[:, None]), rcond=1e-14, hermitian=True)
    rms = float(np.sqrt(np.mean((sigma - form.predict(numbers)) ** 2)))
    heldout = _held_out(form, sigma, share, scatter)
    return Fit(form, numbers, covariance, len(sigma) - len(numbers), scatter, rms, heldout)


def choose(fits: Sequence[Fit]) -> int:
    """Index of the simplest law that is as good on held-out poses as the best, within one standard error."""
    best = min(range(len(fits)), key=lambda i: fits[i].score)
    order = sorted(range(len(fits)), key=lambda i: (len(fits[i].numbers), fits[i].score))
    for i in order:
        worse = fits[i].heldout ** 2 - fits[best].heldout ** 2
        worse = worse[np.isfinite(worse)]
        if i == best or worse.mean() <= worse.std() / np.sqrt(max(len(worse), 1)):
            return i
    return best


def _solve(form: Form, sigma: Array, share: Array, scatter: float | None = None) -> tuple[Array, float]:
    """Numbers, and the scatter (share) between poses, found unless it is given."""
    numbers, extra = form.start(sigma), scatter or 0.0
    low, high = form.bounds()
    numbers = np.clip(numbers, low, high)
    about = sigma
    for _ in range(ROUNDS):
        error = np.sqrt(share**2 + extra**2) * np.maximum(about, SMALLEST)
        found = least_squares(
            lambda p, error=error: (form.predict(p) - sigma) / error, numbers, bounds=(low, high), x_scale="jac"
        )
        numbers = found.x
        # weights follow the law, not the measurement: else a value that is low by chance counts more
        about = form.predict(numbers)
        if scatter is None:
            extra = _scatter(np.log(sigma / np.maximum(about, SMALLEST)), share, len(sigma) - len(numbers))
    return numbers, extra


def _scatter(off: Array, share: Array, freedom: int) -> float:
    """The scatter that makes the weighted square of what is left over that of its freedom; 0 where it is less."""
    if freedom <= 0 or (off**2 / share**2).sum() <= freedom:
        return 0.0
    low, high = 0.0, 1.0 + float(np.abs(off).max()) * np.sqrt(len(off))
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if (off**2 / (share**2 + middle**2)).sum() > freedom else (low, middle)
    return high


def _held_out(form: Form, sigma: Array, share: Array, scatter: float) -> Array:
    """(n,) logarithm of measured over predicted by fits to the other folds, over the expected error."""
    n = len(sigma)
    out = np.full(n, np.nan)
    folds = min(FOLDS, n)
    if n <= len(form.names) + 1:
        return out
    expected = np.hypot(share, LEAST_SCATTER)
    for fold in range(folds):
        out_of = np.arange(n) % folds == fold
        numbers, _ = _solve(form.part(~out_of), sigma[~out_of], share[~out_of], scatter)
        value = np.maximum(form.part(out_of).predict(numbers), SMALLEST)
        out[out_of] = np.log(sigma[out_of] / value) / expected[out_of]
    return out


def _slopes(predict: Callable[[Array], Array], numbers: Array, sizes: Array) -> Array:
    """(n, k) derivative of a law by its numbers, by central differences."""
    columns = []
    for i in range(len(numbers)):
        step = np.zeros(len(numbers))
        step[i] = 1e-4 * max(sizes[i], 1e-6)
        columns.append((predict(numbers + step) - predict(numbers - step)) / (2 * step[i]))
    return np.stack(columns, axis=1)
