"""The plate the object stands on: its height along the axis, and views without it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.turntable.axis import Axis
from fusion.turntable.views import Region, View

Array = NDArray[np.float64]


def plate_height(views: Sequence[View], axis: Axis, region: Region) -> float | None:
    """Height of the plate along the axis [m], measured from the axis' point; None when no plate is seen.

    The plate is the lowest of the large level surfaces in the region.
    """
    heights = []
    for v in views[:: max(1, len(views) // 25)]:
        level = region.holds(v.map.points) & (np.einsum("vuk,k->vu", v.map.normals, axis.direction) > 0.97)
        heights.append(axis.distance(v.map.points[level].astype(float))[1])
    height = np.concatenate(heights) if heights else np.zeros(0)
    seen = sum(int(region.holds(v.map.points).sum()) for v in views[:: max(1, len(views) // 25)])
    if len(height) < max(200, 0.02 * seen):
        return None
    cell = 0.004
    counts, borders = np.histogram(height, np.arange(height.min() - cell, height.max() + 2 * cell, cell))
    peak = int(np.flatnonzero(counts > 0.2 * counts.max())[0])
    while peak + 1 < len(counts) and counts[peak + 1] > counts[peak]:
        peak += 1
    middle = (borders[peak] + borders[peak + 1]) / 2
    return float(np.median(height[np.abs(height - middle) < 1.5 * cell]))


def above(view: View, axis: Axis, height: float, most: int) -> View:
    """The view with only source points above a height [m], at most about so many.

    The plate turns into itself: it tells nothing of the angle, and what the camera bends in it pulls to no turn at all.
    """
    kept = np.flatnonzero(axis.distance(view.points.astype(float))[1] > height)
    if len(kept) > most:  # a fixed seed: the same scan gives the same result
        kept = np.sort(np.random.default_rng(0).permutation(kept)[:most])
    return replace(view, points=view.points[kept], normals=view.normals[kept], sigma=view.sigma[kept])
