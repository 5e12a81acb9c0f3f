"""A robust standard deviation of every pixel from all frames, in memory that does not depend on their number."""

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.evaluation.still.reference import Reference
from fusion.geometry.robust import MAD_TO_STD

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
        self._per_bin = 1 / self._width
        self._counts = np.zeros((BINS + 1, reference.depth.size), np.uint16)
        self._columns = np.arange(reference.depth.size, dtype=np.int32)
        self._frames = 0

    def add(self, depth: Image) -> None:
        """One more frame (h, w) [m], NaN where missing."""
        self._frames += 1
        if self._frames > MOST:
            return
        off = np.abs(depth - self._reference)
        off *= self._per_bin
        missing = np.isnan(off)
        np.fmin(off, BINS - 1, out=off)
        off[missing] = BINS  # the last row is not used
        at = off.astype(np.int32).ravel()
        at *= np.int32(depth.size)
        at += self._columns
        flat = self._counts.reshape(-1)
        flat[at] += 1  # no index twice: each pixel has its own column

    @property
    def std(self) -> NDArray[np.floating]:
        """(h, w) 1.4826 times the median absolute deviation [m]; NaN below three values, or where most are far off."""
        counts = self._counts[:BINS]
        half = 0.5 * counts.sum(axis=0, dtype=np.uint32)
        # row by row up to the middle: a table of sums would be as large as all counts together, twice
        below, summed, k = np.zeros((3, counts.shape[1]), np.float32)
        inside = np.ones_like(below)
        for row in counts:
            here = summed < half
            k += here
            np.copyto(below, summed, where=here)
            np.copyto(inside, row, where=here)
            summed += row
        k = np.maximum(k - 1, 0)
        median = (k + (half - below) / np.maximum(inside, 1)) * self._width.ravel()
        known = (summed >= 3) & (k < BINS - 1)
        return np.where(known, MAD_TO_STD * median, np.nan).reshape(self._reference.shape)
