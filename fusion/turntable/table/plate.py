"""The plate the object stands on: its height along the axis, and views without it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.turntable.axis import Axis
from fusion.turntable.table.level import BEYOND, LEAST_SECTORS, SIDES, THICK, is_plate, steady_at
from fusion.turntable.table.slab import LOWEST, WIDER, reach_of, thickness_of
from fusion.turntable.views import ObjectView

Array = NDArray[np.float64]
THICKEST = 0.6  # of the size a plate may stand above the table, where what turns seems to end (guess)
HIDDEN = 0.6  # of the size: of a foot hardly before what it stands on, nothing may be seen to turn (guess)
NOISES = 3.0  # standard deviations of noise that THICK of the size is at least
CELL = 0.04  # of the size, of heights
RIM = 4  # rings beyond the outermost in which a rim shows itself
# share of the radius that most sides reach: nearly all do of plates (8 in 10 before a bent camera), 2 in 10 of a table
# whose far edge is seen
ROUND = 0.8
# points of all views that make a level surface, and their share of what turns: the noise of walls is level here and
# there, 0.02 % of a pile of bricks (guesses)
LEAST_LEVEL, LEVEL_SHARE = 200, 0.02
NEAR_PLATE = 0.3  # of the size, how far from its plane a plate may seem to be, bent by a camera that is not calibrated


@dataclass(frozen=True)
class Plate:
    """What the object stands on."""

    height: float  # of its surface along the axis [m], measured from the axis' point
    # that of the table below it, where the plate is not round, so that it is seen to turn; else None
    table: float | None = None
    thickness: float = 0.0  # how thick it may be at most where it is not round, in widths


def find_plate(views: Sequence[ObjectView], axis: Axis, motions: Array | None = None) -> Plate | None:
    """The plate, or the table where that alone is seen; None when there is neither.

    The plate is the largest level surface near the foot of what turns that is seen all round and does not turn itself:
    an object without a plate may have a level part there. The table below is such a surface too, but goes on where a
    plate has its rim. Where a table is seen alone, a plate of another shape may turn close above it.

    Args:
        views: (n) of the object.
        axis: of the turn.
        motions: (n, 4, 4) what brings the object from its place at angle 0 to that in each view; None: plates of other
            shapes are not looked for.
    """
    step, size = max(1, len(views) // 25), size_of(views, axis)
    some, turned = views[::step], None if motions is None else motions[::step]
    for below in (NEAR_PLATE, HIDDEN):
        levels = level_heights(some, axis, (below, THICKEST), size)
        found = [h for h in levels if is_plate(some, axis, h, size)]
        rimmed = next((h for h in found if has_a_rim(some, axis, h, size)), None)
        if rimmed is not None:
            return Plate(rimmed)
        # a plate that is wider than what is seen to turn hides the table up to its border
        tables = found or [h for h in levels if is_plate(some, axis, h, size, max(WIDER) * BEYOND)]
        slab = None if turned is None or not tables else _slab(some, axis, turned, min(tables), size)
        if slab is not None:
            return slab
        if found:
            return Plate(found[0])
    return None


def size_of(views: Sequence[ObjectView], axis: Axis) -> float:
    """Radius or half the height of what turns [m], whichever is more: lengths about its plate are shares of it.

    What is as small as its noise counts as larger.
    """
    radius, height = axis.distance(np.concatenate([v.points for v in views]).astype(float))
    low, high = np.percentile(height, [1, 99])
    noise = float(np.median(np.concatenate([v.sigma for v in views])))
    return max(float(np.percentile(radius, 95)), (high - low) / 2, NOISES * noise / THICK)


def has_a_rim(views: Sequence[ObjectView], axis: Axis, height: float, size: float) -> bool:
    """True when the level surface at a height [m] is round about the axis and one looks past it outside, as beyond a
    plate; a table goes on, to its own edges or those of the image. The size [m] is that of what turns."""
    shown = np.concatenate([v.map.points[np.isfinite(v.map.points[..., 2])] for v in views]).astype(float)
    radius, above = axis.distance(shown)
    thick = THICK * size
    here = radius[np.abs(above - height) < thick]
    if not len(here):
        return False
    told, share, there = steady_at(views, axis, height, BEYOND * float(np.percentile(here, 95)), thick)
    outermost = int(np.flatnonzero(there.sum(axis=1) >= LEAST_SECTORS).max(initial=-1))
    ends = there.shape[0] - 1 - np.argmax(there[::-1], axis=0)[there.any(axis=0)]  # of each side
    beyond = (told & (share < 0.2))[outermost + 1 : outermost + 1 + RIM]
    return bool(np.mean(ends >= ROUND * outermost) >= SIDES and beyond.any(axis=0).sum() >= LEAST_SECTORS)


def _slab(views: Sequence[ObjectView], axis: Axis, motions: Array, ground: float, size: float) -> Plate | None:
    """A plate that turns above a table that stands still; None where there is none."""
    reach = max(WIDER) * reach_of(views, axis)
    near = [axis.distance(_level(v, axis)) for v in views]
    height = np.concatenate([h[r < reach] for r, h in near])
    limits = (ground + LOWEST * size, ground + THICKEST * size)
    height = height[(height > limits[0]) & (height < limits[1])]
    levels = _largest(height, limits, CELL * size) if _enough(height, views) else []
    for level in levels:
        thickness = thickness_of(views, axis, motions, (level, ground), size)
        if thickness is not None:
            return Plate(level, ground, thickness)
    return None


def _level(view: ObjectView, axis: Axis) -> Array:
    """(n, 3) points of level surfaces [m]."""
    level = np.einsum("vuk,k->vu", view.map.normals, axis.direction) > 0.97
    return np.asarray(view.map.points[level].astype(float))


def ground_height(views: Sequence[ObjectView], axis: Axis) -> float | None:
    """The same for the largest level surface, plate or table; None when there is none.

    What lies above it shows how the object turns. Where that is the table, the plate and its rim serve too: they say
    nothing of the angle, but hold the axis where an object is nearly round.
    """
    some, size = views[:: max(1, len(views) // 25)], size_of(views, axis)
    levels = level_heights(some, axis, (NEAR_PLATE, NEAR_PLATE), size)
    return next((h for h in levels if is_plate(some, axis, h, size)), None)


def level_heights(views: Sequence[ObjectView], axis: Axis, about: tuple[float, float], size: float) -> list[float]:
    """Where much level surface lies [m], so far below to so far above the foot, in sizes [m], the largest first."""
    foot = float(np.percentile(np.concatenate([axis.distance(v.points.astype(float))[1] for v in views]), 1))
    height = np.concatenate([axis.distance(_level(v, axis))[1] for v in views])
    low, high = foot - about[0] * size, foot + about[1] * size
    height = height[(height > low) & (height < high)]
    return _largest(height, (low, high), CELL * size) if _enough(height, views) else []


def _enough(height: Array, views: Sequence[ObjectView]) -> bool:
    """Whether heights (n,) of level points are those of a surface."""
    return len(height) >= max(LEAST_LEVEL, LEVEL_SHARE * sum(len(v.points) for v in views))


def _largest(height: Array, limits: tuple[float, float], cell: float) -> list[float]:
    """The medians of the fullest cells [m], the fullest first."""
    counts, borders = np.histogram(height, np.arange(limits[0], limits[1] + cell, cell))
    least, levels = 0.2 * float(np.max(counts)), []
    while float(np.max(counts)) > max(least, 0):
        best = int(np.argmax(counts))
        levels.append(float(np.median(height[np.abs(height - borders[best] - cell / 2) < 1.5 * cell])))
        counts[max(0, best - 2) : best + 3] = 0
    return levels
