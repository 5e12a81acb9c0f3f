"""Frames of one scene that follow each other: their mean and scatter, and how alike the noise is in time and space."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.calibration.series import PixelSeries
from fusion.discrepancy.observe.tiles import Tiling
from fusion.sensor.view import Image

REACH_PX = 8  # pixels farther apart are taken to share no noise
SMOOTH_PX = 15  # over which the noise is taken to be one: a pixel's own scatter over a few frames says little
MOST_PAIRS = 4  # of frames for the likeness in space: it has far more pixels than it needs


class FrameSeries:
    """Statistics of depth frames that are added in the order in which they were taken."""

    def __init__(self, shape: tuple[int, int], tiles: Tiling | None = None) -> None:
        """
        Args:
            tiles: squares whose course from frame to frame is wanted, beside the image.
        """
        self.pixels, self.tiles = PixelSeries(shape), tiles
        self._first = np.full(shape, np.nan)
        self._course: list[NDArray[np.float64]] = []
        self._seen = np.zeros(0 if tiles is None else len(tiles))
        self._squares = np.zeros(shape)
        self._pairs = np.zeros(shape, np.int32)
        self._last: Image | None = None
        self._alike: list[NDArray[np.float64]] = []

    def add(self, depth: Image) -> None:
        """One more frame [m], NaN where missing."""
        self.pixels.add(depth)
        if self._last is not None:
            change = np.asarray(depth, float) - self._last
            known = np.isfinite(change)
            self._squares += np.where(known, change, 0.0) ** 2
            self._pairs += known
            if len(self._alike) < MOST_PAIRS:
                self._alike.append(likeness(change))
        self._last = np.asarray(depth, float)
        if self.tiles is not None:
            self._first = np.where(np.isfinite(self._first), self._first, self._last)
            change = self._last - self._first
            seen = np.maximum(self.tiles.mean(np.isfinite(change).astype(float)), 1e-3)
            self._course.append(self.tiles.mean(change) / seen)
            self._seen = self._seen + seen * self.tiles.pixels

    @property
    def course(self) -> NDArray[np.float64] | None:
        """(frames, tiles) depth [m] of each tile less what all frames have in common; None where it is not wanted.

        Of pixels against themselves, so that one that is missing in a frame does not move its tile.
        """
        if not self._course:
            return None
        course = np.array(self._course)
        return np.asarray(course - course.mean(axis=0))

    @property
    def seen(self) -> NDArray[np.float64]:
        """(tiles,) pixels of each with a value, on average over the frames."""
        return self._seen / max(len(self._course), 1)

    @property
    def succession(self) -> Image:
        """(h, w) half the mean square [m^2] of the change from a frame to the next: the variance of noise that is new
        in every frame; NaN without two frames in a row."""
        return np.where(self._pairs > 0, 0.5 * self._squares / np.maximum(self._pairs, 1), np.nan)

    @property
    def alike(self) -> NDArray[np.float64] | None:
        """(2, k) correlation of the noise of pixels 0, 1, ... apart along u and along v; None below two frames."""
        return np.mean(self._alike, axis=0) if self._alike else None


def likeness(*changes: Image) -> NDArray[np.float64]:
    """(2, REACH_PX + 1) correlation of neighbours in differences (h, w) of two frames, along u and along v."""
    products, pairs = np.sum([_products(change) for change in changes], axis=0)
    powers, pixels = np.maximum(products[:, :1], 1e-30), np.maximum(pairs[:, :1], 1)
    return np.asarray(products / np.maximum(pairs, 1) / (powers / pixels))


def _products(change: Image) -> NDArray[np.float64]:
    """(2, 2, REACH_PX + 1) sums of products of neighbours, and of how many, along u and along v."""
    known, square = np.isfinite(change), np.maximum(local_mean(change**2), 0.0)  # a running sum may end below 0
    # a pixel far out is no noise, and one of them would outweigh all others
    sound = known & (np.abs(change) < 4 * np.sqrt(square)) & (square > 0)
    unit = np.where(sound, np.nan_to_num(change) / np.sqrt(np.maximum(square, 1e-30)), 0.0)
    out = np.zeros((2, 2, REACH_PX + 1))
    for axis in (0, 1):
        for apart in range(REACH_PX + 1):
            one, other = _shifted(unit, apart, axis)
            both = np.logical_and(*_shifted(sound, apart, axis)).sum()
            out[:, axis, apart] = float((one * other).sum()), float(both)
    return out


def local_mean(image: Image) -> Image:
    """(h, w) mean of what is known of an image over squares of `SMOOTH_PX`."""
    known, size = np.isfinite(image), (SMOOTH_PX, SMOOTH_PX)
    parts = np.where(known, image, 0.0), known
    whole, share = (cv2.blur(part.astype(float), size, borderType=cv2.BORDER_REFLECT) for part in parts)
    return np.asarray(whole / np.maximum(share, 1e-3))


def _shifted(image: NDArray[Any], apart: int, axis: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """The image without its last pixels and without its first ones, along u (0) or v (1)."""
    end = max(image.shape[1 - axis] - apart, 0)  # of fewer pixels than that none are so far apart
    return (image[:, :end], image[:, apart:]) if axis == 0 else (image[:end], image[apart:])


def filter_window(alike: NDArray[np.float64] | None) -> float:
    """[px^2] of the Gaussian window that makes the noise of neighbours as alike as it is, where that is most.

    What pixels far apart share too is no filter's.

    Args:
        alike: (2, k) correlations, see `FrameSeries.alike`.
    """
    if alike is None:
        return 0.0
    next_to, far = alike[:, 1], alike[:, -1]
    shared = np.clip((next_to - far) / np.maximum(1.0 - far, 1e-9), 1e-9, 1.0 - 1e-3)
    return -0.25 / float(np.log(shared.max()))
