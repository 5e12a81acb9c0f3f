"""Drift of a still series: its slope with an interval that knows of slow noise, and whether the camera is warm."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

BLOCKS = 60  # means that a series is thinned to: what is faster than a block is white there
FEWEST = 6  # values below which nothing is said
HORIZON = 600.0  # [s] of scanning that must stay within the tolerance
TOLERANCE = 0.001  # [m]
SURE = 0.95  # probability that a verdict needs
LEVEL = 0.90  # of the intervals
# [s] time constants of a warm-up: seconds of a small sensor to the 40 to 50 min (three constants) of Tolgyessy 2021
WARMING = np.geomspace(20.0, 3600.0, 24)
DRAWS = 4000
SHORTEST = 60.0  # [s] a shorter recording cannot tell a warm-up from noise of some seconds

Array = NDArray[np.floating]


@dataclass(frozen=True)
class Drift:
    """What a series says about its future.

    Attributes:
        time, value: (b,) means of blocks [s], [m].
        fitted: (b,) warm-up curve, the mean of all that agree with the data [m].
        slope, slope_interval: [m/s] of a straight line, and its 90 % interval; NaN where nothing can be said.
        change, change_interval: within the next ten minutes [m].
        constant: time constant of the warm-up [s], where it is told by the data; else NaN.
        wait_min: minutes until ten minutes stay within a millimetre, and its 90 % interval; None when ready or unknown.
        verdict: "ready", "not warmed up" or "too short to say".
        text: the same in one sentence.
    """

    time: Array
    value: Array
    fitted: Array
    slope: float
    slope_interval: tuple[float, float]
    change: float
    change_interval: tuple[float, float]
    constant: float
    wait_min: tuple[float, float, float] | None
    verdict: str
    text: str


def drift_of(time: Array, value: Array, tolerance: float = TOLERANCE) -> Drift:
    """Drift of a series (n,) [s], [m]; NaN is left out.

    Noise that changes slowly looks like drift: it is taken as a process whose correlation falls exponentially, with
    every correlation time weighed by how well it fits. The warm-up is an exponential approach, weighed the same way.
    """
    time, value = _blocks(np.asarray(time, float), np.asarray(value, float))
    long = time[-1] - time[0] if len(time) else 0.0
    if len(time) < FEWEST or not long > 0:
        return _nothing(time, value, "Too short to say whether the camera is warm: fewer than six moments with depth.")
    t = time - time[0]
    line = _posterior(t, value, [np.column_stack([np.ones_like(t), t / long])])
    curves, tau, warm = _warm_up(t, value)
    later = warm.coefficients[:, 1] * (_rise(long + HORIZON, long, tau) - 1.0)
    slope = line.coefficients[:, 1] / long
    fitted = np.mean([c @ np.array(k) for c, k in _some(warm, curves)], axis=0)
    verdict, wait = _verdict(later, tau, (tolerance, long))
    told = np.quantile(tau, [0.05, 0.95])
    # the prior spans a factor of 180: the data have told something when they leave less than ten
    constant = float(np.median(tau)) if told[1] / told[0] < 10 else float("nan")
    change = float(np.median(later))
    return Drift(time, value, fitted, float(np.median(slope)), _interval(slope), change, _interval(later), constant,
                 wait, verdict, _text(verdict, wait, (long, change, _interval(later)), tolerance))  # fmt: skip


def _warm_up(t: Array, value: Array) -> tuple[list[Array], Array, "_Draws"]:
    """Curves, the time constant of each draw, the draws: first over all time constants, then closer over the likely."""
    constants = WARMING
    for _ in range(2):
        curves = [np.column_stack([np.ones_like(t), _rise(t, float(t[-1]), tau)]) for tau in constants]
        draws = _posterior(t, value, curves)
        tau = constants[draws.model]
        # one step of the grid beyond what is likely
        low, high = np.quantile(tau, [0.005, 0.995]) * np.array([1 / 1.25, 1.25])
        constants = np.geomspace(max(low, WARMING[0]), min(high, WARMING[-1]), len(WARMING))
    return curves, tau, draws


@dataclass(frozen=True)
class _Draws:
    """Draws from what the data leave possible: which design (d,), and its coefficients (d, 2)."""

    model: NDArray[np.intp]
    coefficients: Array


def _posterior(t: Array, value: Array, designs: list[Array]) -> _Draws:
    """Every design with every correlation time, weighed by its likelihood; flat priors, 1 / sigma^2 for the noise."""
    rng = np.random.default_rng(0)
    dt = np.diff(t)
    fits, weights = [], []
    for model, X in enumerate(designs):
        for correlation in np.geomspace(0.2 * np.median(dt[dt > 0]), 3 * t[-1], 14):
            a = np.exp(-dt / correlation)
            gain = np.sqrt(np.maximum(1 - a * a, 1e-12))
            whitened = [_white(column, a, gain) for column in (value, *X.T)]
            y, A = whitened[0], np.column_stack(whitened[1:])
            information = A.T @ A
            best = np.linalg.solve(information, A.T @ y)
            rest = max(float(((y - A @ best) ** 2).sum()), 1e-30)
            freedom = len(y) - A.shape[1]
            log = -np.log(gain).sum() - 0.5 * np.linalg.slogdet(information)[1] - 0.5 * freedom * np.log(rest)
            fits.append((model, best, np.linalg.inv(information), rest, freedom))
            weights.append(log)
    share = np.exp(np.array(weights) - max(weights))
    chosen = rng.choice(len(fits), DRAWS, p=share / share.sum())
    drawn, models = np.empty((DRAWS, 2)), np.empty(DRAWS, np.intp)
    for i in np.unique(chosen):
        model, best, covariance, rest, freedom = fits[i]
        at = chosen == i
        variance = rest / rng.chisquare(freedom, int(at.sum()))
        drawn[at] = best + rng.multivariate_normal(np.zeros(2), covariance, int(at.sum())) * np.sqrt(variance)[:, None]
        models[at] = model
    return _Draws(models, drawn)


def _white(x: Array, a: Array, gain: Array) -> Array:
    """A series without its correlation: each value less what the one before tells of it."""
    return np.concatenate([x[:1], (x[1:] - a * x[:-1]) / gain])


def _rise(t: Array | float, long: float, tau: Array | float) -> Array:
    """An exponential approach, 0 at the start and 1 after `long` [s]; a line where tau is much longer."""
    return np.asarray(np.expm1(-np.asarray(t) / tau) / np.expm1(-long / np.asarray(tau)))


def _some(draws: _Draws, designs: list[Array]) -> list[tuple[Array, Array]]:
    step = max(1, DRAWS // 400)
    return [(designs[m], c) for m, c in zip(draws.model[::step], draws.coefficients[::step], strict=True)]


def _verdict(later: Array, tau: Array, asked: tuple[float, float]) -> tuple[str, tuple[float, float, float] | None]:
    """The verdict and the waiting time; `asked` is the tolerance [m] and how long was recorded [s]."""
    tolerance, long = asked
    far = np.abs(later) > tolerance
    if (~far).mean() >= SURE:
        return "ready", None
    if far.mean() < SURE or long < SHORTEST:
        return "too short to say", None
    wait = np.where(far, tau * np.log(np.maximum(np.abs(later) / tolerance, 1.0)), 0.0) / 60
    low, middle, high = np.quantile(wait, [(1 - LEVEL) / 2, 0.5, (1 + LEVEL) / 2])
    return "not warmed up", (float(middle), float(low), float(high))


def _text(verdict: str, wait: tuple[float, ...] | None, seen: tuple[float, float, tuple], tolerance: float) -> str:
    long, change, (low, high) = seen
    of = f"{change * 1e3:+.2f} mm in the next ten minutes ({low * 1e3:+.2f} to {high * 1e3:+.2f})"
    if verdict == "ready":
        return f"Ready: warmed up, the depth changes by {of}."
    if wait is not None:
        return f"Not warmed up, wait about {max(wait[0], 1):.0f} min ({wait[1]:.0f} to {wait[2]:.0f}): {of}."
    if long < SHORTEST:
        return f"Too short to say whether the camera is warm: {long:.1f} s recorded, some minutes are needed."
    return (
        f"Too short to say whether the camera is warm: {long:.0f} s leave {low * 1e3:+.1f} to {high * 1e3:+.1f} mm "
        f"for the next ten minutes, {tolerance * 1e3:g} mm is asked. Record for some minutes."
    )


def _interval(draws: Array) -> tuple[float, float]:
    low, high = np.quantile(draws, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return float(low), float(high)


def _blocks(time: Array, value: Array) -> tuple[Array, Array]:
    """Means of up to 60 blocks of the finite values, in the order of time."""
    known = np.isfinite(value) & np.isfinite(time)
    order = np.argsort(time[known], kind="stable")
    t, x = time[known][order], value[known][order]
    if len(t) > 2 * BLOCKS:
        parts = np.array_split(np.arange(len(t)), BLOCKS)
        t, x = np.array([t[p].mean() for p in parts]), np.array([x[p].mean() for p in parts])
    advancing = np.concatenate([[True], np.diff(t) > 0]) if len(t) else np.zeros(0, bool)
    return t[advancing], x[advancing]


def _nothing(time: Array, value: Array, text: str) -> Drift:
    none = float("nan")
    return Drift(
        time, value, np.full(len(time), none), none, (none, none), none, (none, none), none, None, "too short to say",
        text,
    )  # fmt: skip
