"""What a pixel sees most of the time: a depth and a noise that a person walking by does not change."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

QUARTILES_TO_STD = np.float32(0.7413)  # their distance, of a normal distribution
NEAR = 0.05  # share of the depth: values further off belong to something else
WIDE = 6.0  # standard deviations
RARE = 0.5  # share of the frames: a pixel that has a depth less often has no usual one
LEAST_M, LEAST_SHARE = 0.03, 0.02  # nothing nearer to the reference than this has moved: people move by more
THING = 5e-4  # share of the image: smaller things are the sensor's own outliers
ROWS = 16  # of the image at a time: as much as stays in a processor's cache
BORDER = 9  # [px] around what moves: mixed pixels

Image = NDArray[np.floating]


@dataclass(frozen=True)
class Reference:
    """The usual view of a still stretch, from a sample of its frames."""

    depth: NDArray[np.float32]  # (h, w) [m], NaN where no frame has a value
    sigma: NDArray[np.float32]  # (h, w) robust standard deviation of one depth [m]; NaN below three values
    usual: NDArray[np.bool_]  # (h, w) pixels that have a depth in half of the frames or more
    frames: int  # number of frames in the sample

    def limit(self) -> NDArray[np.float32]:
        """(h, w) how far a depth may be from the reference before it is not that surface [m]."""
        sigma = WIDE * cv2.medianBlur(np.nan_to_num(self.sigma), 5)
        return np.maximum(sigma, np.maximum(LEAST_M, LEAST_SHARE * np.nan_to_num(self.depth)))

    def moving(self, depth: Image, limit: Image) -> NDArray[np.bool_]:
        """(h, w) pixels of a frame at which something larger than single pixels is not where it usually is."""
        with np.errstate(invalid="ignore"):
            off = ((np.abs(depth - self.depth) > limit) & self.usual).astype(np.uint8)
        solid = cv2.erode(off, np.ones((3, 3), np.uint8))
        if not solid.any():
            return np.zeros(depth.shape, bool)
        count, label, stats, _ = cv2.connectedComponentsWithStats(solid, connectivity=8)
        large = stats[:, cv2.CC_STAT_AREA] >= max(THING * depth.size, 9)
        large[0] = False
        if not large.any() or count < 2:
            return np.zeros(depth.shape, bool)
        return np.asarray(cv2.dilate(large[label].astype(np.uint8), np.ones((BORDER, BORDER), np.uint8)) > 0)


def reference_of(depths: Sequence[Image]) -> Reference:
    """The reference of frames (h, w) [m]; all are held in memory."""
    parts = [_part([depth[v : v + ROWS] for depth in depths]) for v in range(0, len(depths[0]), ROWS)]
    depth, sigma, usual = (np.concatenate([part[i] for part in parts]) for i in range(3))
    return Reference(depth, sigma, usual, len(depths))


def _part(depths: Sequence[Image]) -> tuple[NDArray, NDArray, NDArray]:
    """Depth, sigma and usual (r, w) of some rows of the frames."""
    shape = depths[0].shape
    values = np.stack([np.ravel(depth) for depth in depths], axis=1).astype(np.float32)  # (pixels, frames)
    ordered = np.sort(values, axis=1)  # NaN goes last
    usual = np.isfinite(ordered).sum(axis=1) >= RARE * values.shape[1]
    centre = _shortest_half(ordered)
    with np.errstate(invalid="ignore"):
        far = np.abs(ordered - centre[:, None]) > NEAR * centre[:, None]
    disturbed = np.flatnonzero(far.any(axis=1))
    if len(disturbed):
        ordered[disturbed] = np.sort(np.where(far[disturbed], np.float32(np.nan), ordered[disturbed]), axis=1)
    count = np.isfinite(ordered).sum(axis=1)
    low, centre, high = (_quantile(ordered, count, share) for share in (0.25, 0.5, 0.75))
    sigma = np.where(count >= 3, QUARTILES_TO_STD * (high - low), np.float32(np.nan))
    return centre.reshape(shape), sigma.reshape(shape), usual.reshape(shape)


def _shortest_half(ordered: NDArray[np.float32]) -> NDArray[np.float32]:
    """(p,) median of the shortest half of each row (p, n) in order, NaN last: right while half the values are."""
    counts = np.isfinite(ordered).sum(axis=1)
    centre = np.full(len(ordered), np.nan, np.float32)
    for n in np.unique(counts[counts > 0]):
        rows = np.flatnonzero(counts == n)
        x, half = ordered[rows, :n], n // 2 + 1
        start = (x[:, half - 1 :] - x[:, : n - half + 1]).argmin(axis=1)
        at = np.arange(len(rows))
        centre[rows] = 0.5 * (x[at, start + (half - 1) // 2] + x[at, start + half // 2])
    return centre


def _quantile(ordered: NDArray[np.float32], count: NDArray[np.intp], share: float) -> NDArray[np.float32]:
    """(p,) quantile of the first `count` values of each row, which are in order; NaN where there is none."""
    place = share * np.maximum(count - 1, 0)
    low = place.astype(np.intp)
    rows = np.arange(len(ordered))
    below, above = ordered[rows, low], ordered[rows, np.minimum(low + 1, np.maximum(count - 1, 0))]
    return np.asarray(below + (place - low).astype(np.float32) * (above - below))
