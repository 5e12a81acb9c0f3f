"""What stands behind the turning object: the farthest surface of each pixel that hangs together with what stands still.

A wall that the object hides most of the time is seen now and then. It goes on smoothly from the parts that are never
hidden, so it is followed from these, as planes do in inverse depth, as long as what was seen there at some time lies
on the plane of its surroundings. The hull of what turns lies before it by a step, or meets a table at an edge, where
the plane does not go on. What the object hides always is filled in from around.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float32]
CELL = 4  # [px] the background is followed in cells of this size: it is smooth, and rays are many
WINDOW = 11  # cells of a plane
LEAST_CELLS = 12  # that make a plane (guess)
USUAL = 0.5  # share of a pixel's depths that are those of what stands there, where little passes before it
RARE = 0.05  # share of a pixel's depths that may lie farther than what stands there: outliers (guess)


@dataclass(frozen=True)
class Behind:
    """What depth images may show behind the object."""

    far: Image  # (h, w) farthest depth that was seen more than rarely [m], NaN where unknown
    still: NDArray[np.bool_]  # (h, w) pixels that always see the same depth
    # (h, w) pixels that see their farthest depth in most frames; an arm may have passed before it
    usual: NDArray[np.bool_]
    limit: Image  # (h, w) depths that differ by less are the same [m]


def find_background(seen: Behind, outside: NDArray[np.bool_]) -> Image:
    """Depth (h, w) [m] from which on a pixel shows the background; NaN where none is known.

    Args:
        seen: what the images show.
        outside: (h, w) pixels whose farthest surface lies outside the region of the object: only what reaches out of
            it is sure to be none of it.
    """
    step, start = CELL, CELL // 2
    far, limit = (np.ascontiguousarray(a[start::step, start::step]) for a in (seen.far, seen.limit))
    sure = (seen.usual & outside)[start::step, start::step] & np.isfinite(far)
    nothing = np.full(seen.far.shape, np.nan, np.float32)
    if sure.sum() < LEAST_CELLS:
        return nothing
    nearness = np.zeros(far.shape, np.float32)
    nearness[sure] = 1 / far[sure]
    nearness, sure = followed(nearness, sure, far, limit)
    behind, known = _filled(nearness, sure)
    behind = np.where(known, 1 / np.maximum(behind, 1e-3), np.nan).astype(np.float32)
    # filled in: what was seen there stands before it, so the border lies between the two; what was seen behind it says
    # that it was filled in wrongly
    with np.errstate(invalid="ignore"):
        middle = np.where(far < behind + limit, behind - limit, np.nan)
        middle = np.where(far < behind - limit, (far + behind) / 2, middle)
    border = np.where(sure, 1 / np.maximum(nearness, 1e-3) - limit, np.where(np.isfinite(far), middle, behind - limit))
    h, w = seen.far.shape
    wide = cv2.resize(np.nan_to_num(border, nan=np.inf).astype(np.float32), (w, h), interpolation=cv2.INTER_NEAREST)
    # at full resolution where the surface itself was seen there
    near = np.asarray(cv2.dilate(np.abs(np.nan_to_num(1 / wide)), np.ones((2 * step + 1, 2 * step + 1), np.uint8)))
    with np.errstate(invalid="ignore", divide="ignore"):
        own = (seen.far + seen.limit >= 1 / near) & (seen.far >= wide - 2 * seen.limit) & np.isfinite(wide)
        found = np.where(own, np.minimum(wide, seen.far - seen.limit), wide)
    return np.where(np.isfinite(found), found, np.nan).astype(np.float32)


def followed(nearness: Image, sure: NDArray[np.bool_], far: Image, limit: Image) -> tuple[Image, NDArray[np.bool_]]:
    """Inverse depth and where it is known, followed from what is sure over what was seen on the same plane."""
    waiting = np.isfinite(far) & ~sure
    for _ in range(max(far.shape)):
        front = waiting & (cv2.dilate(sure.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0)
        if not front.any():
            break
        plane, told = _planes(nearness, sure, front)
        at = far[front]
        with np.errstate(divide="ignore"):
            good = told & (np.abs(1 / plane - at) < limit[front])
        if not good.any():
            break
        rows, columns = (k[good] for k in np.nonzero(front))
        nearness[rows, columns], sure[rows, columns] = 1 / at[good], True
        waiting &= ~sure
    return nearness, sure


def _filled(nearness: Image, sure: NDArray[np.bool_]) -> tuple[Image, NDArray[np.bool_]]:
    """The same everywhere, each ring on the planes of what it touches, never outside what was seen."""
    nearness, known = nearness.copy(), sure.copy()
    least, most = nearness[sure].min(), nearness[sure].max()
    for _ in range(max(known.shape)):
        front = ~known & (cv2.dilate(known.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0)
        if not front.any():
            break
        plane, told = _planes(nearness, known, front)
        rows, columns = (k[told] for k in np.nonzero(front))
        if not len(rows):
            break
        nearness[rows, columns], known[rows, columns] = np.clip(plane[told], least, most), True
    return nearness, known


def _planes(nearness: Image, known: NDArray[np.bool_], front: NDArray[np.bool_]) -> tuple[NDArray, NDArray[np.bool_]]:
    """At k cells of a front: inverse depth (k,) on the plane of the known cells around, and whether there is one (k,).

    Coordinates count from the middle of the image: sums of squares stay small enough for single precision no longer,
    so they are taken in double.
    """
    h, w = nearness.shape
    rows, columns = np.nonzero(front)
    top, bottom = max(0, rows.min() - WINDOW), min(h, rows.max() + WINDOW + 1)
    left, right = max(0, columns.min() - WINDOW), min(w, columns.max() + WINDOW + 1)
    part = np.s_[top:bottom, left:right]
    weight, value = known[part].astype(float), nearness[part].astype(float)
    y, x = np.mgrid[: bottom - top, : right - left].astype(float)

    def around(image: NDArray) -> NDArray:
        sums = cv2.boxFilter(image, -1, (WINDOW, WINDOW), normalize=False, borderType=cv2.BORDER_CONSTANT)
        return np.asarray(sums[rows - top, columns - left])

    n = np.maximum(around(weight), 1e-9)
    u, v, d = (around(weight * k) / n for k in (x, y, value))
    uu, vv, uv = (around(weight * a * b) / n - m for a, b, m in ((x, x, u * u), (y, y, v * v), (x, y, u * v)))
    ud, vd = (around(weight * a * value) / n - m * d for a, m in ((x, u), (y, v)))
    uu, vv = uu + 0.05, vv + 0.05  # cells in a row tell no slope across it
    det = uu * vv - uv * uv
    slope_u, slope_v = (ud * vv - vd * uv) / det, (vd * uu - ud * uv) / det
    plane = d + slope_u * (columns - left - u) + slope_v * (rows - top - v)
    return plane, (n >= LEAST_CELLS) & (plane > 1e-3)
