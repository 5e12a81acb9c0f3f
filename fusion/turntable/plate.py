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
    counts, borders = np.histogram(height, np.arange(np.min(height) - cell, np.max(height) + 2 * cell, cell))
    peak = int(np.flatnonzero(counts > 0.2 * np.max(counts))[0])
    while peak + 1 < len(counts) and counts[peak + 1] > counts[peak]:
        peak += 1
    middle = (borders[peak] + borders[peak + 1]) / 2
    return float(np.median(height[np.abs(height - middle) < 1.5 * cell]))


def above_plate(vertices: Array, normals: NDArray[np.float32], clear: float) -> NDArray[np.bool_]:
    """Vertices (n,) of an object frame (z up along the axis, plate near 0) that do not belong to the plate.

    What turns about the axis is seen as a surface of revolution, so even a plate that the camera bends is one height
    per radius: the median of the level surface there.

    Args:
        vertices: (n, 3) [m].
        normals: (n, 3) outwards.
        clear: height above the plate up to which vertices still belong to it [m].
    """
    ring = 0.005
    radius = np.hypot(vertices[:, 0], vertices[:, 1])
    level = (normals[:, 2] > 0.9) & (np.abs(vertices[:, 2]) < 4 * clear)
    index = (radius / ring).astype(int)
    heights = np.full(index.max(initial=0) + 1, np.nan)
    for k in np.unique(index[level]):
        here = vertices[level & (index == k), 2]
        if len(here) > 20:
            heights[k] = np.median(here)
    known = np.flatnonzero(np.isfinite(heights))
    if len(known) == 0:
        return np.asarray(vertices[:, 2] > clear)
    # under the object the plate is flat, as far as can be known
    profile = np.interp(np.arange(len(heights)), known, heights[known], left=0.0)
    return np.asarray(vertices[:, 2] > profile[index] + clear)


def above(view: View, axis: Axis, height: float, most: int) -> View:
    """The view with only source points above a height [m], at most about so many.

    The plate turns into itself: it tells nothing of the angle, and what the camera bends in it pulls to no turn at all.
    """
    kept = np.flatnonzero(axis.distance(view.points.astype(float))[1] > height)
    if len(kept) > most:  # a fixed seed: the same scan gives the same result
        kept = np.sort(np.random.default_rng(0).permutation(kept)[:most])
    return replace(view, points=view.points[kept], normals=view.normals[kept], sigma=view.sigma[kept])
