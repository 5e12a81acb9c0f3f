"""What all pixels share from frame to frame: a rig that sways, a scene that creeps, frames that jump as a whole."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

PATCH = 1 / 6  # of width and height: the centre whose mean tells the drift, Pagliari's 100 px of 640
FEWEST = 6  # frames below which nothing is said
SHARED = 0.5  # of the noise of one pixel
DRIFTS = 0.5  # of the variance of the whole centre: the rest, where a straight line takes as much out, is noise
SURE = 5.0  # standard deviations of a slope that is there
CHANGES = 3.0  # times the noise of one pixel: cameras whose frames jump as a whole do so by less (guess)
COARSE = 0.3  # of the gap between depths: above, the noise after rounding is nearly the same at all places (guess)
LEAST_M = 0.002  # [m] no jump of a whole frame is less

Array = NDArray[np.floating]


@dataclass(frozen=True)
class SharedNoise:
    """How the mean depth of many pixels goes from frame to frame, beside what one of them does."""

    frames: int  # with a mean
    common: float  # standard deviation of that mean from frame to frame [m]; NaN below three frames
    one: float  # usual standard deviation of a single pixel [m]
    # slope, slope_std: of a straight line through the means [m/s]; NaN below three frames
    slope: float = float("nan")
    slope_std: float = float("nan")
    steady: bool = False  # the line holds half of what the means do, or more
    coarse: bool = False  # depths lie so far apart that a pixel's noise is that of its place between two of them

    @property
    def changes(self) -> bool:
        """Whether all go up and down by far more than one of them by itself: nothing stands still."""
        return bool(self.common > max(CHANGES * self.one, LEAST_M))

    @property
    def told(self) -> bool:
        """Whether averaging over pixels leaves much of the noise."""
        return bool(self.frames >= FEWEST and not self.coarse and self.common > SHARED * self.one)

    def moves(self, matters: float) -> bool:
        """Whether the depth [m] of a still scene sways or creeps, by more than `matters`."""
        creeps = self.frames >= FEWEST and self.steady and abs(self.slope) > SURE * self.slope_std
        return bool(self.common > matters and (self.told or creeps))

    def text(self, where: str = "the centre") -> str:
        """How much is shared, of what."""
        return f"{self.common * 1e3:.1f} of {self.one * 1e3:.1f} mm noise is shared by all pixels of {where}"

    @property
    def drift_text(self) -> str:
        """How fast it creeps; empty where it does not."""
        return f"the depth drifts by {self.slope * 1e3:+.1f} mm a second" if self.steady else ""


def shared_noise(time: Array, means: Array, one: float, coarse: bool = False) -> SharedNoise:
    """Judge a series: time (n,) [s], means (n,) [m] that may hold NaN; `one`: noise of a single pixel [m]."""
    known = np.isfinite(means)
    t, z = np.asarray(time, float)[known], np.asarray(means, float)[known]
    if len(z) < 3:
        return SharedNoise(len(z), float("nan"), one, coarse=coarse)
    common = float(z.std(ddof=1))
    away = t - t.mean()
    squares = float(away @ away)
    if not squares > 0:
        return SharedNoise(len(z), common, one, coarse=coarse)
    slope = float(away @ z) / squares
    left = z - z.mean() - slope * away
    std = float(np.sqrt(left @ left / (len(z) - 2) / squares))
    return SharedNoise(len(z), common, one, slope, std, bool(np.var(left) <= DRIFTS * np.var(z)), coarse)


def middle_mean(values: Array) -> float:
    """Mean of the middle half of some values, NaN left out: outliers do not move it, nor is it a count of the file."""
    values = np.sort(values[np.isfinite(values)], axis=None)
    cut = len(values) // 4
    return float(values[cut : len(values) - cut].mean()) if len(values) else float("nan")


def centre_of(shape: tuple[int, int]) -> tuple[slice, slice]:
    """The patch in the middle of an image (h, w)."""
    h, w = (max(int(PATCH * side), 1) for side in shape)
    v, u = (shape[0] - h) // 2, (shape[1] - w) // 2
    return slice(v, v + h), slice(u, u + w)
