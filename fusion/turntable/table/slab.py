"""A plate of any shape: a slab that turns close above a table that stands still, and carries what stands on it.

A round plate stands still in every image (see `level`); a square one comes and goes. Turned back by the angles of the
frames it stands still as well, and so does a book that carries the object. The table tells them apart: close below a
plate, one looks past its border onto a level surface that does not turn; a book on a foot has none, or far below. How
high it stands is not how thick it is: one that stands on feet or a bearing is looked under, a carton is not.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import inverse, transform
from fusion.turntable.axis import Axis
from fusion.turntable.table.level import (
    BEYOND,
    LEAST_FRAMES,
    LEAST_RINGS,
    LEAST_SECTORS,
    RINGS,
    SECTORS,
    SIDES,
    STEADY,
    THICK,
    UNSTEADY,
    cells_of,
    counted,
    steady,
)
from fusion.turntable.views import ObjectView

Array = NDArray[np.float64]
LOWEST = 0.05  # of the size above the table: less is its noise (guess)
FLAT = 1 / 4  # of its width is the thickness of a plate at most; a brick or a carton is thicker (guess)
UNDER = 1 / 3  # of the way up from the table, where a slab that stands free is looked under (guess)
INSIDE = 3  # rings within its border, where it is looked under
HALFWAY = 0.45  # of the way down to the table still counts as the slab: what lies below is seen past it
CARRIED = 0.8  # of the points above it stand over it: an arm may reach out, a step on one side carries little (guess)
WIDER = (1, 2)  # as far as plates reach, and as far as those of small things do
PAST = 0.2  # share of the frames in which a cell beyond its border is there at most


def thickness_of(
    views: Sequence[ObjectView], axis: Axis, motions: Array, heights: tuple[float, float], size: float
) -> float | None:
    """How thick a slab may be at most, in widths; None where there is none.

    A slab is a level surface that turns with the object close above a table, is thin, ends all round, and carries it.

    Args:
        views: (n) frames.
        axis: of the turn.
        motions: (n, 4, 4) what brings the object from where it is at angle 0 to where each view sees it.
        heights: of the surface and of the table along the axis [m].
        size: of what turns [m], see `plate.size_of`.
    """
    reach = reach_of(views, axis)
    found = (_thickness(views, axis, motions, heights, (wider * reach, THICK * size)) for wider in WIDER)
    return next((thickness for thickness in found if thickness < FLAT), None)


def _thickness(
    views: Sequence[ObjectView], axis: Axis, motions: Array, heights: tuple[float, float], limits: tuple[float, float]
) -> float:
    height, over, (reach, most) = heights[0], heights[0] - heights[1], limits
    thick = min(most, HALFWAY * over)
    plane = np.array([height, 0.0, 0.0])
    cells = cells_of(axis, plane, reach)
    seen = counted(views, axis, plane, thick, [transform(T, cells) for T in motions])
    told, share, there = steady(seen)
    if there.any(axis=0).mean() < SIDES or (there.sum(axis=1) >= LEAST_SECTORS).sum() < LEAST_RINGS:
        return np.inf
    area = np.arange(RINGS)[:, None] + 0.5
    coming = told & ~_grown(there) & (share > PAST)  # of a cell on the border a part comes and goes
    if (area * coming).sum() >= UNSTEADY * (area * there).sum():
        return np.inf
    ends = np.where(there.any(axis=0), RINGS - np.argmax(there[::-1], axis=0), 0)  # rings of each side
    wide = 2 * float(np.mean(ends[ends > 0])) * reach / RINGS
    beyond = told & (share < PAST) & (np.arange(RINGS)[:, None] >= ends)
    ended = np.asarray(beyond.any(axis=0))[ends > 0].mean() >= SIDES
    radii = ends * reach / RINGS
    if not ended or not _carried(views, axis, motions, height + most, radii):
        return np.inf
    free = _looked_under(views, axis, motions, (heights[1], UNDER * over), radii)
    return over * (1 - UNDER if free else 1) / wide


def _looked_under(
    views: Sequence[ObjectView], axis: Axis, motions: Array, low: tuple[float, float], radii: Array
) -> bool:
    """Whether one sees the table through places so far above it [m], close within a border of such radii [m].

    The sides of what stands on the table hide them. `low`: height of the table along the axis [m], and theirs above it.
    """
    (ground, above), reach = low, float(radii.max())
    plane = np.array([ground + above, 0.0, 0.0])
    cells = cells_of(axis, plane, reach)
    seen = counted(views, axis, plane, HALFWAY * above, [transform(T, cells) for T in motions])
    places = np.maximum(RINGS * radii / reach - INSIDE, 0).astype(int), np.arange(SECTORS)
    there, through = seen.there[places], seen.through[places]
    known = (there + through >= LEAST_FRAMES) & (radii > 0)
    return bool(known.mean() >= SIDES and (through > STEADY * (there + through))[known].mean() >= SIDES)


def reach_of(views: Sequence[ObjectView], axis: Axis) -> float:
    """Radius of the outermost ring that is looked at [m]; a hand in less than half of the frames does not count."""
    turning = [axis.distance(v.points.astype(float))[0] for v in views if len(v.points)]
    return BEYOND * float(np.median([np.percentile(radius, 95) for radius in turning]))


def _grown(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Cells (RINGS, SECTORS) and those beside them."""
    around = cells | np.roll(cells, 1, axis=1) | np.roll(cells, -1, axis=1)
    out = around.copy()
    out[1:] |= around[:-1]
    out[:-1] |= around[1:]
    return out


def _carried(views: Sequence[ObjectView], axis: Axis, motions: Array, low: float, radii: Array) -> bool:
    """What turns above a height [m] stands, for the most part, over a slab that reaches so far to each side [m]."""
    shares = []
    for T, v in zip(motions, views, strict=True):
        points = transform(inverse(T), v.points.astype(float))
        radius, height = axis.distance(points)
        x, y = ((points - axis.point) @ axis.across().T).T
        side = np.minimum((np.arctan2(y, x) % (2 * np.pi)) / (2 * np.pi) * SECTORS, SECTORS - 1).astype(int)
        above = height > low
        shares += [(radius <= radii[side])[above].mean()] if above.any() else []
    return bool(shares) and bool(np.median(shares) >= CARRIED)
