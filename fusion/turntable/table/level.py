"""Is a level surface the plate? A plate is round and stays where it is while the object turns; an object's ledge moves.

The plane of the surface is laid out in rings and sectors about the axis, as the camera sees it. In each frame a cell
is there (the surface is measured in it), looked through (what is measured lies below), hidden (what is measured lies
above) or missing. The cells of a plate are there in nearly every frame that does not hide them, on most sides, out to
one radius. A ledge on one side is looked through when it has turned away, and a box's lid at its corners.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.robust import tukey
from fusion.turntable.axis import Axis
from fusion.turntable.views import ObjectView

Array = NDArray[np.float64]
RINGS, SECTORS = 48, 36
BEYOND = 1.6  # rings reach so much farther than what turns
THICK = 0.1  # of the size, off the plane that still counts as it, for a tilted axis and a camera that is not calibrated
LEAST_FRAMES = 3  # that show a cell or look through it
STEADY = 0.8  # share of these frames in which a cell of a plate is there
MEASURED = 0.6  # the same, missing depth counted as not there
SIDES = 0.5  # of all sectors: the far side may be hidden (real plates show 0.75 to 0.9)
LEAST_RINGS = 3
LEAST_SECTORS = SECTORS // 6  # that make a ring
UNSTEADY = 0.3  # largest area that comes and goes, over the steady one: 0.5 for a square that turns, 0.02 for plates


@dataclass(frozen=True)
class CellCounts:
    """Frames in which each cell (RINGS, SECTORS) is there, looked through, and not measured."""

    there: Array
    through: Array
    missing: Array


def is_plate(views: Sequence[ObjectView], axis: Axis, height: float, size: float, beyond: float = BEYOND) -> bool:
    """True when the level surface at a height [m] along the axis is seen on most sides and does not turn.

    Args:
        views: the frames.
        axis: of the turn.
        height: of the surface.
        size: of what turns [m], see `plate.size_of`.
        beyond: it is looked at up to so many times as far as what turns reaches.
    """
    if not any(len(v.points) for v in views):
        return False
    turning = np.concatenate([v.points for v in views]).astype(float)
    reach = beyond * float(np.percentile(axis.distance(turning)[0], 95))
    told, share, there = steady_at(views, axis, height, reach, THICK * size)
    ends = np.where(there.any(axis=0), RINGS - 1 - np.argmax(there[::-1], axis=0), RINGS)  # of each side
    outside = np.arange(RINGS)[:, None] - ends
    rim = (outside > 0) & (outside <= np.ceil(_pixel(views, axis, height) * RINGS / reach))
    unsteady = told & ~there & (share > 0.2) & ~rim
    area = np.arange(RINGS)[:, None] + 0.5
    rings = there.sum(axis=1) >= LEAST_SECTORS
    around = there.any(axis=0).mean() >= SIDES
    return bool(around and rings.sum() >= LEAST_RINGS and (area * unsteady).sum() < UNSTEADY * (area * there).sum())


def _pixel(views: Sequence[ObjectView], axis: Axis, height: float) -> float:
    """How long a pixel is on the level surface along the line of sight [m]: nearer to a rim frames differ by chance."""
    middle = axis.point + height * axis.direction
    away = float(np.linalg.norm(middle))
    sine = abs(float(middle @ axis.direction)) / away
    return away / views[0].map.camera.fy / max(sine, 0.1)


def steady_at(
    views: Sequence[ObjectView], axis: Axis, height: float, reach: float, thick: float
) -> tuple[NDArray[np.bool_], Array, NDArray[np.bool_]]:
    """The same for the cells about an axis at a height, out to a reach; so far off it still counts [m]."""
    plane = _plane(views, axis, height, thick)
    return steady(counted(views, axis, plane, thick, [cells_of(axis, plane, reach)] * len(views)))


def steady(seen: CellCounts) -> tuple[NDArray[np.bool_], Array, NDArray[np.bool_]]:
    """Cells (RINGS, SECTORS) of which something is known, the share of frames in which they are there, steady ones."""
    shown = seen.there + seen.through
    share = seen.there / np.maximum(shown + seen.missing, 1)
    told = shown + seen.missing >= LEAST_FRAMES
    return told, share, told & (seen.there > STEADY * shown) & (share > MEASURED)


def cells_of(axis: Axis, plane: Array, reach: float) -> Array:
    """The middles (RINGS * SECTORS, 3) of the cells of a plane, ring by ring.

    Args:
        axis: z from its point along it, x and y along `across`.
        plane: z = c + a x + b y, as (c, a, b) [m, 1, 1].
        reach: radius of the outermost ring [m].
    """
    radius = (np.arange(RINGS) + 0.5)[:, None] * reach / RINGS
    angle = (np.arange(SECTORS) + 0.5) * 2 * np.pi / SECTORS
    x, y = (radius * np.cos(angle)).ravel(), (radius * np.sin(angle)).ravel()
    z = plane[0] + plane[1] * x + plane[2] * y
    return np.asarray(axis.point + np.column_stack([x, y, z]) @ np.vstack([axis.across(), axis.direction]))


def counted(views: Sequence[ObjectView], axis: Axis, plane: Array, thick: float, cells: Sequence[Array]) -> CellCounts:
    """What the views measure where cells (n, 3), of each view its own, should be.

    Args:
        views: the frames.
        axis, plane: as in `cells_of`.
        thick: what off it still counts as it [m].
        cells: ring by ring.
    """
    count = np.zeros((3, RINGS * SECTORS))
    for v, places in zip(views, cells, strict=True):
        camera = v.map.camera
        column, row = np.round(camera.project(places)).T
        shown = (places[:, 2] > 0.05) & (column >= 0) & (column < camera.width) & (row >= 0) & (row < camera.height)
        measured = np.full((len(places), 3), np.nan)
        measured[shown] = v.map.points[row[shown].astype(int), column[shown].astype(int)]
        above = _above(measured, axis, plane)
        count += [np.abs(above) <= thick, above < -thick, shown & np.isnan(above)]
    return CellCounts(*count.reshape(3, RINGS, SECTORS))


def _above(points: Array, axis: Axis, plane: Array) -> Array:
    """Height (n,) of points (n, 3) above the plane [m]."""
    offset = points - axis.point
    flat = offset @ axis.across().T
    return np.asarray(offset @ axis.direction - plane[0] - flat @ plane[1:])


def _plane(views: Sequence[ObjectView], axis: Axis, height: float, thick: float) -> Array:
    """(c, a, b) of the level points near a height: an axis that is only guessed leans against its plate."""
    level = [v.map.points[np.einsum("vuk,k->vu", v.map.normals, axis.direction) > 0.9] for v in views]
    points = np.concatenate(level)[:: max(1, sum(map(len, level)) // 20_000)].astype(float)
    points = points[np.abs(_above(points, axis, np.array([height, 0.0, 0.0]))) < 3 * thick]
    terms = np.column_stack([np.ones(len(points)), (points - axis.point) @ axis.across().T])
    z = (points - axis.point) @ axis.direction
    plane = np.array([height, 0.0, 0.0])
    for _ in range(6):
        weight = tukey((z - terms @ plane) / thick, cut=1.5)
        ridge = 1e-2 * max(float(weight.sum()), 1.0) * np.diag([1e-3, 1e-3, 1e-3])
        step = np.linalg.solve((terms * weight[:, None]).T @ terms + ridge, terms.T @ (weight * (z - terms @ plane)))
        plane = plane + step
    return np.asarray(plane)
