"""Rounding and noise: what standard deviation stood in front of the rounding."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.effects.readout.depth_quantization import rounded

PHASES = 64  # places within a step
FINEST = 0.12  # steps: a smaller noise hardly ever changes a value
COUNTS_APART = 1.2  # levels this many counts apart or more are rounded to counts a second time


def without_rounding(sigma: float, sigma_std: float, step: float, span: float) -> tuple[float, float]:
    """Noise before the rounding [m] and how well it is known, from the scatter of rounded values.

    Args:
        sigma, sigma_std: of the rounded values [m].
        step: of the rounding [m].
        span: range of the true depths of the pixels that were pooled [m]: over many steps the phase averages out.
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
        unsure = float(np.interp(found, at, scatter)) / np.sqrt(1 + 2 * span / step)
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
