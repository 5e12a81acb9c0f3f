"""A robust standard deviation of every pixel from all frames, in memory that does not depend on their number."""

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.evaluation.reference import MAD_TO_STD, Reference

BINS = 32
MOST = 65535  # frames: then the shares are long settled, and the counters full
PER_SIGMA = 6.0  # bins in one standard deviation of the reference

Image = NDArray[np.floating]


class RobustSpread:
    """Histograms of how far each depth is from the reference; their medians are median absolute deviations."""

    def __init__(self, reference: Reference) -> None:
        """Bins of a pixel are a sixth of the noise that the reference has around it."""
        around = cv2.medianBlur(np.nan_to_num(reference.sigma), 5)
        known = around[around > 0]
        smallest = float(np.median(known)) / 4 if known.size else 1e-3
        self._reference = reference.depth
        self._width = np.maximum(around, smallest) / PER_SIGMA
        self._counts = np.zeros((BINS + 1, reference.depth.size), np.uint16)
        self._columns = np.arange(reference.depth.size, dtype=np.int32)
        self._frames = 0

    def add(self, depth: Image) -> None:
        """One more frame (h, w) [m], NaN where missing."""
        self._frames += 1
        if self._frames > MOST:
            return
        off = np.abs(depth - self._reference) / self._width
        bins = np.fmin(off, BINS - 1)
        bins[np.isnan(off)] = BINS  # the last row is not used
        at = bins.astype(np.int32).ravel() * np.int32(depth.size) + self._columns
        flat = self._counts.reshape(-1)
        flat[at] += 1  # no index twice: each pixel has its own column

    @property
    def std(self) -> NDArray[np.floating]:
        """(h, w) 1.4826 times the median absolute deviation [m]; NaN below three values, or where most are far off."""
        shape = self._reference.shape
        summed = self._counts[:BINS].cumsum(axis=0, dtype=np.uint32)
        total = summed[-1]
        half = 0.5 * total
        k = (summed < half).sum(axis=0).clip(0, BINS - 1)
        below = np.where(k > 0, summed[np.maximum(k - 1, 0), self._columns], 0)
        inside = np.maximum(self._counts[k, self._columns], 1)
        median = (k + (half - below) / inside) * self._width.ravel()
        return np.where((total >= 3) & (k < BINS - 1), MAD_TO_STD * median, np.nan).reshape(shape)
