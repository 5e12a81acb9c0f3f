"""Unrounded: what a sensor rounds, how large its steps are, and how much of a change is seen behind them."""

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from fusion.geometry.camera import Camera
from fusion.sensor.effect import Effect
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image, View

STEP = 12**0.5  # over the spread of what rounding to it loses
HIDDEN = 0.46  # of a step: noise that leaves a two-hundredth of it, which is a tenth of that noise in a square's mean
NEXT_LEVEL = 1.5  # steps: more than one, which is as far as rounding moves a pixel, and fewer than two
STEPS = 4.0  # that an image must go over, so that their places count alike (guess)
SOME = 5000  # of its pixels are enough for that
ENDS = (0.05, 0.95)  # of its pixels, between which it does
MOVED = 0.1  # of a step: about as far as a law that is looked for moves what is rounded


def rounding_of(sensor: Sensor) -> Effect | None:
    """The effect of a model that rounds depths; None without: it is the last that happens to a depth."""
    return next((effect for effect in sensor.effects if effect.lattice), None)


def next_level(sensor: Sensor, depth: Image, camera: Camera) -> Image | float:
    """(h, w) [m] by which the rounding of a model moves no pixel of a depth (h, w) [m]; 0 without."""
    rounding, view = rounding_of(sensor), View(camera, baseline=sensor.baseline)
    with np.errstate(all="ignore"):
        return 0.0 if rounding is None else NEXT_LEVEL * STEP * rounding.noise(depth, view)


@dataclass(frozen=True)
class Unrounded:
    """What is rounded; all (h, w)."""

    rounding: Effect  # the effect
    mean: Image  # of repeated frames without it [m]
    step: Image  # at this depth [m]: constant, or growing with its square
    spread: Image  # of the noise before it, in steps: as the model or the frames say, what is calmer
    speckle: Image | float  # the same of what is frozen while a scene stands still: another in every pixel

    @classmethod
    def of(cls, sensor: Sensor, rounding: Effect, mean: Image, sigma: Image, std: Image, view: View) -> "Unrounded":
        """From the prediction of a sensor without its rounding and the measured spread `std` (h, w) [m]."""
        with np.errstate(all="ignore"):
            step = np.asarray(STEP * rounding.noise(mean, view))
            spread = sigma / step
            spread = spread * _shown(spread, (std / step) ** 2, mean / step)
            frozen = [effect.noise(mean, view) ** 2 for effect in sensor.effects if effect.frozen == "scene"]
            return cls(rounding, mean, step, spread, np.sqrt(sum(frozen, np.zeros(()))) / step)

    def shows(self, inside: NDArray[np.bool_]) -> bool:
        """True where the noise at some pixels (h, w) is small enough not to hide the steps."""
        return bool(inside.any() and np.nanmedian(self.smoothed[inside]) < HIDDEN)

    @cached_property
    def smoothed(self) -> Image:
        """(h, w) spread, in steps, of all by which the pixels of a square differ."""
        return np.hypot(self.spread, self.speckle)

    def rounded(self, view: View) -> Image:
        """(h, w) mean of repeated frames and of speckle behind the rounding [m]."""
        with np.errstate(all="ignore"):
            return self.rounding.repeated(self.mean, self.smoothed * self.step, view)[0]

    def passed(self, view: View) -> Image:
        """(h, w) share of a small change before the rounding that is seen behind it: 0 amid a step, 1 where noise or
        a slope goes over many."""
        with np.errstate(all="ignore"):
            ends = [self.mean + side * MOVED * self.step for side in (-1.0, 1.0)]
            low, high = (self.rounding.repeated(end, self.smoothed * self.step, view)[0] for end in ends)
            return np.nan_to_num((high - low) / (2 * MOVED * self.step), nan=1.0)


def _shown(spread: Image, variance: Image, phase: Image) -> float:
    """Share of a model's spread (h, w) that frames show which scatter with a variance (h, w), at most 1; all in steps.

    Amid a step they scatter by nothing, and beside its edge far more: of many steps all places count alike, and of few
    nobody knows how near their edges are.
    """
    known = np.flatnonzero(np.isfinite(spread) & np.isfinite(variance) & np.isfinite(phase))
    known = known[:: max(1, len(known) // SOME)]
    if not len(known) or np.ptp(np.quantile(phase.flat[known], ENDS)) < STEPS:
        return 1.0
    stated, seen = np.broadcast_to(spread, phase.shape).flat[known], float(np.mean(variance.flat[known]))

    def missing(share: float) -> float:
        return float(np.mean(_behind(share * stated))) - seen

    if missing(1.0) <= 0.0:
        return 1.0
    return 0.0 if missing(0.0) >= 0.0 else float(brentq(missing, 0.0, 1.0, xtol=1e-3))


def _behind(spread: Image) -> Image:
    """Variance behind a rounding of noise before it, over all phases; all in steps."""
    size, behind = _table()
    return np.where(spread < 1.0, np.interp(spread, size, behind), spread**2 + 1 / 12)


@cache
def _table() -> NDArray[np.float64]:
    """(2, k) spreads below a step, and the variances behind it."""
    size, k = np.linspace(0.0, 1.0, 101), np.arange(1, 50)[:, None]
    behind = size**2 + 1 / 12 - (np.exp(-((2 * np.pi * k * size) ** 2)) / (2 * (np.pi * k) ** 2)).sum(axis=0)
    return np.stack([size, behind])
