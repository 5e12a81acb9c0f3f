"""Valid, no-data and outlier shares, noise and offset in small tiles of the image, and over one variable at a time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.evaluation.still.statistics import Still
from fusion.evaluation.surface import ExpectedSurface

ACROSS = 40  # tiles over the width of the image
FILLED = 0.5  # share of a tile that must belong to the region
FEWEST = 300  # values in a bin that is shown
ANGLE = np.deg2rad(np.arange(0, 91, 10.0))
BINS = 12  # at most

Array = NDArray[np.floating]


@dataclass(frozen=True)
class StretchTiles:
    """Tiles of one or more stretches, t of them."""

    depth: Array  # expected [m]
    incidence: Array  # between ray and normal [rad]
    brightness: Array  # mean of IR, or of colour where there is no IR [count]; NaN without both
    # valid, missing, outliers: values counted
    valid: Array
    missing: Array
    outliers: Array
    sigma: Array  # standard deviation of one depth [m]
    offset: Array  # mean depth less the expected [m]


@dataclass(frozen=True)
class Shares:
    """Shares over one variable, k bins."""

    variable: str  # "depth" [m], "incidence" [rad] or "brightness" [count]
    # low, high: (k,) of the bins
    low: Array
    high: Array
    # valid, missing, outliers: (k,) shares, one in sum
    valid: Array
    missing: Array
    outliers: Array
    values: Array  # (k,) how many
    sigma: Array  # (k,) median noise [m]


def tiles_of(still: Still, surface: ExpectedSurface) -> StretchTiles:
    """Tiles of a stretch that lie in its region."""
    side = max(4, surface.depth.shape[1] // ACROSS)
    region = surface.region & np.isfinite(surface.depth) if surface.kind != "unknown" else surface.region
    seen = np.where(region, still.frames - still.moved, 0)
    valid = np.where(region, still.depth.count, 0)
    outliers = np.where(region, still.outliers, 0)
    # what moves hides some missing values too
    missing = np.maximum(seen - valid - outliers, 0)
    light = brightness_of(still)
    with np.errstate(invalid="ignore"):
        offset = still.depth.mean - surface.depth
    means = [surface.depth, surface.incidence, light, still.depth.std, offset]
    sums = [_sum(image.astype(float), side) for image in (valid, missing, outliers)]
    parts = [_mean(np.where(region, image, np.nan), side) for image in means]
    keep = _sum(region.astype(float), side) >= FILLED * side * side
    depth, incidence, bright, sigma, off = (part[keep] for part in parts)
    good, none, far = (part[keep] for part in sums)
    return StretchTiles(depth, incidence, bright, good, none, far, sigma, off)


def brightness_of(still: Still) -> Array:
    """(h, w) mean IR, or mean of the colour channels where there is no IR [count]."""
    if still.ir is not None:
        return still.ir.mean
    if still.color is not None:
        return still.color.mean.mean(axis=2)
    return np.full(still.outliers.shape, np.nan)


def joined(tiles: Sequence[StretchTiles]) -> StretchTiles:
    """The tiles of all stretches."""
    names = list(StretchTiles.__dataclass_fields__)
    return StretchTiles(*(np.concatenate([getattr(part, name) for part in tiles]) for name in names))


def shares_over(tiles: StretchTiles, variable: str) -> Shares | None:
    """Shares in bins of one variable; None when it is not known, or does not vary."""
    values = getattr(tiles, variable)
    known = np.isfinite(values)
    if not known.any():
        return None
    edges = ANGLE if variable == "incidence" else _edges(values[known], variable)
    bins = np.clip(np.digitize(values, edges) - 1, 0, len(edges) - 2)
    counts = np.array([
        [part[known & (bins == k)].sum() for part in (tiles.valid, tiles.missing, tiles.outliers)]
        for k in range(len(edges) - 1)
    ])  # fmt: skip
    total = counts.sum(axis=1)
    shown = np.flatnonzero(total >= FEWEST)
    if not len(shown):
        return None
    share = counts[shown] / total[shown, None]
    sigma = [_median(tiles.sigma[known & (bins == k)]) for k in shown]
    good, none, far = share.T
    return Shares(variable, edges[shown], edges[shown + 1], good, none, far, total[shown], np.array(sigma))


def _edges(values: Array, variable: str) -> Array:
    """Bin borders: round steps of depth, equal factors of brightness."""
    low, high = float(np.min(values)), float(np.max(values))
    if variable == "brightness":
        low = max(low, high * 1e-4, 1e-9)
        return np.geomspace(low, max(high, low * 1.0001) * 1.0001, min(BINS, 1 + int(4 * np.log2(high / low) + 1)) + 1)
    step = next(s for s in (0.01, 0.02, 0.05, 0.1, 0.2, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 1e9) if (high - low) / s < BINS)
    return np.arange(np.floor(low / step), np.floor(high / step) + 2) * step


def _blocks(image: Array, side: int) -> Array:
    """(rows, columns, side * side) of whole tiles."""
    rows, columns = image.shape[0] // side, image.shape[1] // side
    cut = image[: rows * side, : columns * side].reshape(rows, side, columns, side)
    return cut.transpose(0, 2, 1, 3).reshape(rows, columns, side * side)


def _sum(image: Array, side: int) -> Array:
    return _blocks(image, side).sum(axis=2)


def _mean(image: Array, side: int) -> Array:
    blocks = _blocks(image, side)
    known = np.isfinite(blocks)
    count = known.sum(axis=2)
    total = np.where(known, blocks, 0.0).sum(axis=2)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _median(values: Array) -> float:
    values = values[np.isfinite(values)]
    return float(np.median(values)) if len(values) else float("nan")
