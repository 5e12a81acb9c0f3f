"""Succession: what a sensor that mixes each frame with the one before makes of the scatter of a few frames."""

from functools import lru_cache

import numpy as np

from fusion.geometry.camera import Camera
from fusion.sensor.effect import Effect
from fusion.sensor.moment import Moment
from fusion.sensor.view import View

SETTLED = 60  # frames after which a filter has forgotten its start


@lru_cache(maxsize=1024)
def succession_of(memory: float, frames: int, started: bool) -> tuple[float, float]:
    """Logarithms of two expectations for noise that is new in every frame in front of the filter, with variance 1.

    Args:
        memory: share of the frame before.
        frames: that are looked at, in a row.
        started: the first of them is the filter's first, which it leaves as it is; else it has settled long before.

    Returns:
        of the sample variance of the frames, and of half the mean square of the change from one to the next over it.
    """
    before = 0 if started else SETTLED
    mixing = np.zeros((frames + before, frames + before))
    for t in range(len(mixing)):
        mixing[t] = memory * mixing[t - 1] if t else 0.0
        mixing[t, t] = 1 - memory if t else 1.0
    kept = mixing[before:]
    covariance = kept @ kept.T
    whole = (np.trace(covariance) - covariance.sum() / frames) / (frames - 1)
    changes = np.diff(kept, axis=0)
    renewed = 0.5 * float(np.mean((changes**2).sum(axis=1)))
    return float(np.log(whole)), float(np.log(renewed / whole))


def memory_of(effect: Effect) -> float:
    """Share of the frame before that is in each frame behind an effect [1]: so much less of its noise is new."""
    if not effect.changes("spread"):
        return 0.0
    depth = np.ones((1, 1))
    view = View(Camera(1, 1, 1.0, 1.0, 0.0, 0.0), depth, moment=Moment(previous=depth))
    return max(0.0, 1.0 - float(np.mean(effect.spread(np.ones_like(depth), depth, view))))
