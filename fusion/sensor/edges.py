"""From depth jumps between neighbouring pixels to the nearest edge of every pixel."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fusion.sensor.view import Edges, Image

REACH_PX = 8.0
BRIGHTEST = 1000.0  # the light across an edge over an own amplitude of nearly nothing stays a number
OVERSHADOWED_PX, LARGER = 1.5, 3.0  # an edge is left out where one with a jump so many times as large is so close
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class Crossings:
    """Where an edge passes between two neighbouring pixels.

    Attributes:
        first, second: (n,) indices of the pixels in the raveled image; the second is to the right or below.
        position: (n,) share of the way from the first to the second.
        depths: (n, 2) [m] at the edge, on the side of the first and of the second; NaN where there is nothing.
    """

    first: Indices
    second: Indices
    position: Image
    depths: Image


@dataclass(frozen=True)
class _Lines:
    """Straight pieces of edges: `start` and `end` (n, 2) [px, u v], and the crossings (n,) at both."""

    start: Image
    end: Image
    at_start: Indices
    at_end: Indices


def nearest_edges(crossings: Crossings, depth: Image, amplitude: Image) -> Edges:
    """The edge that is nearest to each pixel, at most REACH_PX away.

    An edge beside one with a jump three times as large is left out. Crossings of one 2 x 2 cell are joined to lines,
    so that distances to a straight edge are exact.

    Args:
        depth, amplitude: (h, w) of the pixels; the amplitude in any unit.
    """
    empty = Edges(*(np.full(depth.shape, value, np.float32) for value in (np.inf, 0.0, 0.0, 1.0)))
    if not len(crossings.first):
        return empty
    crossings = _dominant(crossings, depth.shape[1])
    lines = _lines(crossings, depth.shape)
    v, u = _near(crossings, depth.shape)
    pixels = np.column_stack([u, v]).astype(np.float32)
    foot, line, share = _feet(lines, pixels)
    away = foot - pixels
    distance = np.hypot(away[:, 0], away[:, 1])
    close = distance <= REACH_PX
    v, u, foot, line, share = (values[close] for values in (v, u, foot, line, share))
    crossing = np.where(share < 0.5, lines.at_start[line], lines.at_end[line])
    normal = _towards_far(crossings, lines)[line]
    side = _side(crossings, crossing, away[close], normal, depth[v, u])
    empty.distance[v, u] = distance[close]
    empty.direction[v, u] = np.arctan2(away[close, 1], away[close, 0])
    empty.jump[v, u], empty.light[v, u] = _across(crossings, crossing, side, depth[v, u], amplitude, (v, u))
    return empty


def _points(crossings: Crossings, width: int) -> Image:
    """(n, 2) [px, u v]."""
    v, u = np.divmod(crossings.first, width)
    right = crossings.second == crossings.first + 1
    return np.column_stack(
        [u + np.where(right, crossings.position, 0), v + np.where(right, 0, crossings.position)]
    ).astype(np.float32)


def _dominant(crossings: Crossings, width: int) -> Crossings:
    """Leave out crossings close to one with a jump several times as large: on the brink of a surface, its own folds."""
    jump = np.nan_to_num(np.abs(crossings.depths[:, 1] - crossings.depths[:, 0]), nan=np.inf)
    near = cKDTree(_points(crossings, width)).query_pairs(OVERSHADOWED_PX, output_type="ndarray")
    a, b = near[:, 0], near[:, 1]
    weak = np.zeros(len(jump), bool)
    weak[a[jump[a] * LARGER < jump[b]]] = True
    weak[b[jump[b] * LARGER < jump[a]]] = True
    keep = ~weak
    return Crossings(crossings.first[keep], crossings.second[keep], crossings.position[keep], crossings.depths[keep])


def _lines(crossings: Crossings, shape: tuple[int, ...]) -> _Lines:
    """Join the crossings on the sides of each 2 x 2 cell: two by a line, others to their centre."""
    height, width = shape
    on_side = np.full((4, height + 1, width + 1), -1, np.intp)  # top, left, bottom and right side of the cell
    v, u = np.divmod(crossings.first, width)
    right = crossings.second == crossings.first + 1
    which = np.arange(len(v))
    # the cell with corner pixel (v, u) is stored at (v + 1, u + 1): cells outside the image exist, and stay open
    on_side[0, v[right] + 1, u[right] + 1] = which[right]
    on_side[2, v[right], u[right] + 1] = which[right]
    on_side[1, v[~right] + 1, u[~right] + 1] = which[~right]
    on_side[3, v[~right] + 1, u[~right]] = which[~right]
    cells = on_side.reshape(4, -1).T
    cells = cells[(cells >= 0).any(axis=1)]
    points = _points(crossings, width)
    held = cells >= 0
    count = held.sum(axis=1)
    pair = np.sort(cells[count == 2], axis=1)[:, 2:]
    other, held = cells[count != 2], held[count != 2]
    centre = (points[other] * held[..., None]).sum(axis=1) / held.sum(axis=1)[:, None]
    of, side = np.nonzero(held)
    spoke = other[of, side]
    return _Lines(
        np.concatenate([points[pair[:, 0]], points[spoke]]),
        np.concatenate([points[pair[:, 1]], centre[of]]).astype(np.float32),
        np.concatenate([pair[:, 0], spoke]),
        np.concatenate([pair[:, 1], spoke]),
    )


def _near(crossings: Crossings, shape: tuple[int, ...]) -> tuple[Indices, Indices]:
    """Rows and columns of the pixels that may have an edge within reach."""
    beside = np.ones(shape, np.uint8)
    beside.reshape(-1)[crossings.first] = 0
    beside.reshape(-1)[crossings.second] = 0
    v, u = np.nonzero(cv2.distanceTransform(beside, cv2.DIST_L2, cv2.DIST_MASK_5) <= REACH_PX)
    return v, u


def _feet(lines: _Lines, pixels: Image) -> tuple[Image, Indices, Image]:
    """The point of the lines nearest to each pixel (n, 2) [px], its line, and the share of the line before it."""
    middle = (lines.start + lines.end) / 2
    count = min(3, len(middle))  # lines are at most 1.5 px long: the nearest is among the three nearest middles
    _, near = cKDTree(middle, balanced_tree=False, compact_nodes=False).query(pixels, k=count, workers=-1)
    near = near.reshape(len(pixels), count)
    start, along = lines.start[near], (lines.end - lines.start)[near]
    length = np.maximum(along[..., 0] ** 2 + along[..., 1] ** 2, np.float32(1e-12))
    towards = pixels[:, None] - start
    share = np.clip((towards[..., 0] * along[..., 0] + towards[..., 1] * along[..., 1]) / length, 0.0, 1.0)
    feet = start + share[..., None] * along
    gap = feet - pixels[:, None]
    best = np.argmin(gap[..., 0] ** 2 + gap[..., 1] ** 2, axis=1)
    rows = np.arange(len(pixels))
    return feet[rows, best], near[rows, best], share[rows, best]


def _towards_far(crossings: Crossings, lines: _Lines) -> Image:
    """(n, 2) normals of lines, to the side of the farther surface."""
    along = lines.end - lines.start
    normal = np.column_stack([-along[:, 1], along[:, 0]])
    right = crossings.second == crossings.first + 1
    across = np.column_stack([right, ~right]).astype(np.float32)
    # of the two pairs of pixels the one that the line passes between, not along
    turned = [(normal * across[c]).sum(axis=1) for c in (lines.at_start, lines.at_end)]
    use_end = np.abs(turned[1]) > np.abs(turned[0])
    crossing = np.where(use_end, lines.at_end, lines.at_start)
    sign = np.where(use_end, turned[1], turned[0])
    sign = np.where(_second_is_far(crossings)[crossing], sign, -sign)
    outwards = np.where(_second_is_far(crossings)[crossing][:, None], across[crossing], -across[crossing])
    point = np.abs(sign) < 1e-9  # a line without length has no normal of its own
    return np.where(point[:, None], outwards, normal * np.sign(sign)[:, None])


def _second_is_far(crossings: Crossings) -> NDArray[np.bool_]:
    """(n,) where the second pixel sees the farther surface; nothing is farther than anything."""
    far = np.where(np.isnan(crossings.depths), np.inf, crossings.depths)
    return far[:, 1] > far[:, 0]


def _side(crossings: Crossings, crossing: Indices, away: Image, normal: Image, depth: Image) -> Indices:
    """(n,) 0 where a pixel is on the side of its crossing's first pixel, 1 where on that of the second.

    Args:
        crossing: (n,) of each pixel.
        away: (n, 2) from the pixel to the edge [px].
        normal: (n, 2) of the edge, towards the farther surface.
        depth: (n,) of the pixels.
    """
    along = (away * normal).sum(axis=1)
    second = (along < 0) == _second_is_far(crossings)[crossing]
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
