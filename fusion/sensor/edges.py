"""From depth jumps between neighbouring pixels to the nearest edge of every pixel."""

import cv2
import numpy as np

from fusion.sensor.edge_lines import (
    Crossings,
    Indices,
    dominant,
    lines_of,
    nearest_points,
    second_is_far,
    towards_far,
)
from fusion.sensor.view import Edges, Image

REACH_PX = 8.0
BRIGHTEST = 1000.0  # the light across an edge over an own amplitude of nearly nothing stays a number


def nearest_edges(crossings: Crossings, depth: Image, amplitude: Image, reach: float = REACH_PX) -> Edges:
    """The edge that is nearest to each pixel, at most `reach` [px] away.

    An edge beside one with a jump three times as large is left out. Crossings of one 2 x 2 cell are joined to lines,
    so that distances to a straight edge are exact.

    Args:
        depth, amplitude: (h, w) of the pixels; the amplitude in any unit.
    """
    empty = Edges(*(np.full(depth.shape, value, np.float32) for value in (np.inf, 0.0, 0.0, 1.0)))
    if not len(crossings.first):
        return empty
    crossings = dominant(crossings, depth.shape[1])
    lines = lines_of(crossings, depth.shape)
    v, u = _near(crossings, depth.shape, reach)
    pixels = np.column_stack([u, v]).astype(np.float32)
    foot, line, share = nearest_points(lines, pixels)
    away = foot - pixels
    distance = np.hypot(away[:, 0], away[:, 1])
    close = distance <= reach
    v, u, foot, line, share = (values[close] for values in (v, u, foot, line, share))
    crossing = np.where(share < 0.5, lines.at_start[line], lines.at_end[line])
    normal = towards_far(crossings, lines)[line]
    side = _side(crossings, crossing, away[close], normal, depth[v, u])
    empty.distance[v, u] = distance[close]
    empty.direction[v, u] = np.arctan2(away[close, 1], away[close, 0])
    empty.jump[v, u], empty.light[v, u] = _across(crossings, crossing, side, depth[v, u], amplitude, (v, u))
    return empty


def _near(crossings: Crossings, shape: tuple[int, ...], reach: float) -> tuple[Indices, Indices]:
    """Rows and columns of the pixels that may have an edge within reach."""
    beside = np.ones(shape, np.uint8)
    beside.reshape(-1)[crossings.first] = 0
    beside.reshape(-1)[crossings.second] = 0
    v, u = np.nonzero(cv2.distanceTransform(beside, cv2.DIST_L2, cv2.DIST_MASK_5) <= reach)
    return v, u


def _side(crossings: Crossings, crossing: Indices, away: Image, normal: Image, depth: Image) -> Indices:
    """(n,) 0 where a pixel is on the side of its crossing's first pixel, 1 where on that of the second.

    Args:
        crossing: (n,) of each pixel.
        away: (n, 2) from the pixel to the edge [px].
        normal: (n, 2) of the edge, towards the farther surface.
        depth: (n,) of the pixels.
    """
    along = (away * normal).sum(axis=1)
    second = (along < 0) == second_is_far(crossings)[crossing]
    # past the end of a line its normal tells little: the depth tells
    ends = crossings.depths[crossing]
    nothing = ~np.isfinite(depth)
    apart = np.abs(np.where(np.isfinite(ends), ends, np.inf) - np.where(nothing, np.nan, depth)[:, None])
    by_depth = np.where(nothing, np.isnan(ends[:, 1]), apart[:, 1] < apart[:, 0])
    askew = np.abs(along) < 0.87 * np.linalg.norm(away, axis=1) * np.linalg.norm(normal, axis=1)  # 30 deg
    return np.where(nothing | np.isnan(ends).any(axis=1) | askew, by_depth, second).astype(np.intp)


def _across(
    crossings: Crossings, crossing: Indices, side: Indices, depth: Image, amplitude: Image, place: tuple
) -> tuple[Image, Image]:
    """Jump and light ratio (n,) of pixels from their own side to the other."""
    rows = np.arange(len(side))
    ends = crossings.depths[crossing]
    jump = ends[rows, 1 - side] - ends[rows, side]
    other = np.where(side == 0, crossings.second[crossing], crossings.first[crossing])
    with np.errstate(all="ignore"):
        light = np.minimum(amplitude.reshape(-1)[other] / amplitude[place], BRIGHTEST)
    nothing = ~np.isfinite(jump) | ~np.isfinite(depth)
    return np.where(nothing, 0.0, jump), np.where(nothing, 0.0, np.nan_to_num(light, nan=1.0))
