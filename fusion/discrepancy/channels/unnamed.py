"""Unnamed: what a channel shows that depends on something known, and that no effect of the catalogue explains."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

Vector = NDArray[np.float64]

KNOTS = 5
MOST = 2  # variables
FALSE_ALARM = 1e-6
REPLICATED = 0.5  # of the gain that must show in recordings that took no part in the fit
WORTH = 0.15  # of the gain of the first variable: one that brings less is not named


@dataclass(frozen=True)
class Unnamed:
    """A law without a name.

    Attributes:
        variables: it depends on.
        gain: drop of the chi2.
        probability: of that by chance.
        fitted: (n,) what it changes.
    """

    variables: tuple[str, ...]
    gain: float
    probability: float
    fitted: Vector


def unnamed(excess: Vector, sigma: Vector, place: NDArray[np.intp], variables: dict[str, Vector]) -> Unnamed | None:
    """The variables whose smooth functions explain tiles (n,) also in recordings left out; None when none do.

    Args:
        excess: measured less predicted, with standard deviations `sigma`.
        place: recording of each.
        variables: (n,) each, by name.
    """
    places = np.unique(place)
    if len(places) < 3 or len(excess) < 10 * KNOTS:
        return None
    white = np.clip(excess / sigma, -8, 8)
    columns = {name: _hats(values) / sigma[:, None] for name, values in variables.items() if np.ptp(values) > 0}
    chosen: list[str] = []
    gains: list[float] = []
    for _ in range(MOST):
        rest = {name: _gain(white, [columns[n] for n in (*chosen, name)]) for name in columns if name not in chosen}
        best = max(rest, key=lambda name: rest[name], default=None)
        if best is None or (chosen and rest[best] - gains[-1] < WORTH * gains[0]):
            break
        chosen.append(best)
        gains.append(rest[best])
    if not chosen:
        return None
    A = np.concatenate([columns[name] for name in chosen], axis=1)
    fitted = A @ _weights(A, white)
    inflated = max(1.0, float((np.median(np.abs(white - fitted)) / 0.6745) ** 2))
    probability = float(min(1.0, len(columns) * chi2.sf(gains[-1] / inflated, A.shape[1])))
    held = 0.0
    for g in places:
        part = place == g
        left = white[part] - A[part] @ _weights(A[~part], white[~part])
        held += float(white[part] @ white[part] - left @ left)
    if probability > FALSE_ALARM or held < REPLICATED * gains[-1]:
        return None
    return Unnamed(tuple(chosen), gains[-1], probability, fitted * sigma)


def _gain(white: Vector, parts: list[NDArray[np.float64]]) -> float:
    A = np.concatenate(parts, axis=1)
    left = white - A @ _weights(A, white)
    return float(white @ white - left @ left)


def _weights(A: NDArray[np.float64], white: Vector) -> Vector:
    ridge = 1e-6 * max(float(np.trace(A.T @ A)) / A.shape[1], 1e-300)
    return np.asarray(np.linalg.solve(A.T @ A + ridge * np.eye(A.shape[1]), A.T @ white))


def _hats(values: Vector) -> NDArray[np.float64]:
    """(n, k) piecewise linear functions with knots at quantiles, which together are a constant too."""
    knots = np.unique(np.quantile(values, np.linspace(0, 1, KNOTS)))
    return np.column_stack([np.interp(values, knots, row) for row in np.eye(len(knots))])
