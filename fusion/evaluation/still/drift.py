"""Drift of a still series: its slope with an interval that knows of slow noise, and whether the camera is warm."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

BLOCKS = 60  # means that a series is thinned to: what is faster than a block is white there
FEWEST = 6  # values below which nothing is said
HORIZON = 600.0  # [s] of scanning that must stay within the tolerance
TOLERANCE = 0.001  # [m] a count of most files
SURE = 0.95  # probability that a verdict needs
LEVEL = 0.90  # of the intervals
# [s] time constants of a warm-up: seconds of a small sensor to the 40 to 50 min (three constants) of Tolgyessy 2021
WARMING = np.geomspace(20.0, 3600.0, 24)
# beyond, in the same steps to ten hours: what a recording of minutes hardly tells from a line
LONGER = WARMING[-1] * (WARMING[1] / WARMING[0]) ** np.arange(1, 11)
LINE = 1e9  # [s] the limit of all time constants: a change that goes on as it does
NEVER = 1e15  # [s] that a line goes on
LIKE_A_LINE = np.log(10.0)  # a line is as likely as all time constants within a factor of so many (guess)
DRAWS = 4000
CORRELATIONS = 14  # times tried, from a fifth of the usual gap to three times the recording
SHORTEST = 60.0  # [s] a shorter recording cannot tell a warm-up from noise of some seconds

Array = NDArray[np.floating]


@dataclass(frozen=True)
class Drift:
    """What a series says about its future."""

    # time, value: (b,) means of blocks [s], [m]
    time: Array
    value: Array
    fitted: Array  # (b,) warm-up curve, the mean of all that agree with the data [m]
    # slope, slope_interval: [m/s] of a straight line, and its 90 % interval; NaN where nothing can be said
    slope: float
    slope_interval: tuple[float, float]
    # change, change_interval: within the next ten minutes [m]
    change: float
    change_interval: tuple[float, float]
    constant: float  # time constant of the warm-up [s], where it is told by the data; else NaN
    # minutes until ten minutes stay within a millimetre, and its 90 % interval; None when ready or unknown, infinite
    # where the change may as well go on for ever
    wait_min: tuple[float, float, float] | None
    verdict: str  # "ready", "not warmed up" or "too short to say"
    text: str  # the same in one sentence


def drift_of(time: Array, value: Array, tolerance: float = TOLERANCE) -> Drift:
    """Drift of a series (n,) [s], [m]; NaN is left out.

    Noise that changes slowly looks like drift: it is taken as a process whose correlation falls exponentially, with
    every correlation time weighed by how well it fits. The warm-up is an exponential approach, weighed the same way,
    and so is its limit, a line: a time constant far longer than the recording cannot be told from it.
    """
    time, value = _blocks(np.asarray(time, float), np.asarray(value, float))
    long = time[-1] - time[0] if len(time) else 0.0
    if len(time) < FEWEST or not long > 0:
        return nothing_told(
            time, value, "Too short to say whether the camera is warm: fewer than six moments with depth."
        )
    t = time - time[0]
    line = _posterior(t, value, (t / long)[:, None])
    curves, tau, warm = _warm_up(t, value)
    later = warm.coefficients[:, 1] * (_rise(long + HORIZON, long, tau) - 1.0)
    slope = line.coefficients[:, 1] / long
    drawn = warm.coefficients[::10]
    fitted = (drawn[:, :1] + drawn[:, 1:] * curves.T[warm.model[::10]]).mean(axis=0)
    verdict, wait = _verdict(later, tau, (tolerance, long))
    told = np.quantile(tau, [0.05, 0.95])
    # the prior spans a factor of 1700, and a line: the data have told something when they leave less than ten
    constant = float(np.median(tau)) if told[1] / told[0] < 10 and told[1] < LINE else float("nan")
    change = float(np.median(later))
    return Drift(time, value, fitted, float(np.median(slope)), _interval(slope), change, _interval(later), constant,
                 wait, verdict, _text(verdict, wait, long, change, _interval(later), tolerance))  # fmt: skip


def _warm_up(t: Array, value: Array) -> tuple[Array, Array, "_Draws"]:
    """Curves (b, k), time constant of each draw, draws: over all time constants, then closer over the likely."""
    constants = np.concatenate([WARMING, LONGER])
    for _ in range(2):
        tried = np.append(constants, LINE)
        curves = _rise(t[:, None], float(t[-1]), tried)
        # flat over the logarithm, in which the constants are equally far apart; the line has a share of its own
        step = np.log(constants[1] / constants[0])
        draws = _posterior(t, value, curves, np.append(np.zeros(len(constants)), np.log(LIKE_A_LINE / step)))
        tau = tried[draws.model]
        bent = tau[tau < LINE]
        if not len(bent):
            break
        # one step of the grid beyond what is likely
        low, high = np.quantile(bent, [0.005, 0.995]) * np.array([1 / 1.25, 1.25])
        constants = np.geomspace(max(low, WARMING[0]), min(high, LONGER[-1]), len(WARMING))
    return curves, tau, draws


@dataclass(frozen=True)
class _Draws:
    """Draws from what the data leave possible: which design (d,), and its coefficients (d, 2)."""

    model: NDArray[np.intp]
    coefficients: Array


def _posterior(t: Array, value: Array, curves: Array, before: Array | float = 0.0) -> _Draws:
    """A constant plus one of the curves (b, k), with every correlation time of the noise, weighed by their likelihood.

    Flat priors but for `before` (k,), the logarithm of what a curve is likely beforehand; 1 / sigma^2 for the noise.
    """
    dt = np.diff(t)
    times = np.geomspace(0.2 * np.median(dt[dt > 0]), 3 * t[-1], CORRELATIONS)
    fits = [_fits(np.exp(-dt / correlation), value, curves) for correlation in times]
    log = np.array([fit.log for fit in fits]) + before  # (correlation, curve)
    share = np.exp(log - log.max()).ravel()
    rng = np.random.default_rng(0)
    chosen = rng.choice(share.size, DRAWS, p=share / share.sum())
    noise, curve = np.divmod(chosen, curves.shape[1])
    best = np.stack([fit.best for fit in fits])[noise, curve]
    root = np.stack([fit.root for fit in fits])[noise, curve]
    rest = np.stack([fit.rest for fit in fits])[noise, curve]
    sigma = np.sqrt(rest / rng.chisquare(len(t) - 2, DRAWS))
    return _Draws(curve, best + sigma[:, None] * np.einsum("dij,dj->di", root, rng.standard_normal((DRAWS, 2))))


@dataclass(frozen=True)
class _Fits:
    """Least squares of k curves: coefficients (k, 2), root of their covariance (k, 2, 2) over the noise, rest (k,)."""

    best: Array
    root: Array
    rest: Array
    log: Array


def _fits(a: Array, value: Array, curves: Array) -> _Fits:
    """Every curve with noise of which each value keeps the share `a` of the one before."""
    gain = np.sqrt(np.maximum(1 - a * a, 1e-12))
    y, one = _white(value, a, gain), _white(np.ones_like(value), a, gain)
    white = np.stack([_white(column, a, gain) for column in curves.T])  # (curve, block)
    information = np.empty((len(white), 2, 2))
    information[:, 0, 0], information[:, 1, 1] = one @ one, (white**2).sum(axis=1)
    information[:, 0, 1] = information[:, 1, 0] = white @ one
    covariance = np.linalg.inv(information)
    best = np.einsum("kij,kj->ki", covariance, np.column_stack([np.full(len(white), one @ y), white @ y]))
    rest = np.maximum(((y - best[:, :1] * one - best[:, 1:] * white) ** 2).sum(axis=1), 1e-30)
    log = -np.log(gain).sum() - 0.5 * np.linalg.slogdet(information)[1] - 0.5 * (len(y) - 2) * np.log(rest)
    return _Fits(best, np.linalg.cholesky(covariance), rest, log)


def _white(x: Array, a: Array, gain: Array) -> Array:
    """A series without its correlation: each value less what the one before tells of it."""
    return np.concatenate([x[:1], (x[1:] - a * x[:-1]) / gain])


def _rise(t: Array | float, long: float, tau: Array | float) -> Array:
    """An exponential approach, 0 at the start and 1 after `long` [s]; a line where tau is much longer."""
    return np.asarray(np.expm1(-np.asarray(t) / tau) / np.expm1(-long / np.asarray(tau)))


def _verdict(later: Array, tau: Array, asked: tuple[float, float]) -> tuple[str, tuple[float, float, float] | None]:
    """The verdict and the waiting time; `asked` is the tolerance [m] and how long was recorded [s]."""
    tolerance, long = asked
    far = np.abs(later) > tolerance
    if long < SHORTEST or max(far.mean(), (~far).mean()) < SURE:
        return "too short to say", None
    if (~far).mean() >= SURE:
        return "ready", None
    left = np.where(tau < LINE, tau * np.log(np.maximum(np.abs(later) / tolerance, 1.0)), NEVER)
    wait = np.where(far, left, 0.0) / 60
    low, middle, high = np.quantile(wait, [(1 - LEVEL) / 2, 0.5, (1 + LEVEL) / 2])
    # between a draw that ends and one that does not a quantile lies far beyond all that end
    middle, low, high = (float(x) if x < NEVER / 60 / DRAWS else float("inf") for x in (middle, low, high))
    return "not warmed up", (middle, low, high)


def _text(
    verdict: str,
    wait: tuple[float, ...] | None,
    long: float,
    change: float,
    interval: tuple[float, float],
    tolerance: float,
) -> str:
    low, high = interval
    of = f"{change * 1e3:+.2f} mm in the next ten minutes ({low * 1e3:+.2f} to {high * 1e3:+.2f})"
    if verdict == "ready":
        return f"Ready: warmed up, the depth changes by {of}."
    if wait is not None and not np.isfinite(wait[2]):
        least = f", {wait[1]:.0f} min or more" if np.isfinite(wait[1]) else ""
        return f"Not warmed up, and no end of it is seen yet{least}: {of}."
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


def nothing_told(time: Array, value: Array, text: str) -> Drift:
    """Of a series (b,) [s], [m] of which no drift can be told, and why."""
    none = float("nan")
    return Drift(
        time, value, np.full(len(time), none), none, (none, none), none, (none, none), none, None, "too short to say",
        text,
    )  # fmt: skip
