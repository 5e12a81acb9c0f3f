"""Depth edges as short straight lines between the places where they pass between neighbouring pixels."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.view import Image

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
class Lines:
    """Straight pieces of edges: `start` and `end` (n, 2) [px, u v], and the crossings (n,) at both."""

    start: Image
    end: Image
    at_start: Indices
    at_end: Indices


def lines_of(crossings: Crossings, shape: tuple[int, ...]) -> Lines:
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
    return Lines(
        np.concatenate([points[pair[:, 0]], points[spoke]]),
        np.concatenate([points[pair[:, 1]], centre[of]]).astype(np.float32),
        np.concatenate([pair[:, 0], spoke]),
        np.concatenate([pair[:, 1], spoke]),
    )


def dominant(crossings: Crossings, width: int) -> Crossings:
    """Leave out crossings close to one with a jump several times as large: on the brink of a surface, its own folds."""
    from scipy.spatial import cKDTree

    jump = np.nan_to_num(np.abs(crossings.depths[:, 1] - crossings.depths[:, 0]), nan=np.inf)
    near = cKDTree(_points(crossings, width)).query_pairs(OVERSHADOWED_PX, output_type="ndarray")
    a, b = near[:, 0], near[:, 1]
    weak = np.zeros(len(jump), bool)
    weak[a[jump[a] * LARGER < jump[b]]] = True
    weak[b[jump[b] * LARGER < jump[a]]] = True
    keep = ~weak
    return Crossings(crossings.first[keep], crossings.second[keep], crossings.position[keep], crossings.depths[keep])


def _points(crossings: Crossings, width: int) -> Image:
    """(n, 2) [px, u v]."""
    v, u = np.divmod(crossings.first, width)
    right = crossings.second == crossings.first + 1
    return np.column_stack(
        [u + np.where(right, crossings.position, 0), v + np.where(right, 0, crossings.position)]
    ).astype(np.float32)


def towards_far(crossings: Crossings, lines: Lines) -> Image:
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
    sign = np.where(second_is_far(crossings)[crossing], sign, -sign)
    outwards = np.where(second_is_far(crossings)[crossing][:, None], across[crossing], -across[crossing])
    point = np.abs(sign) < 1e-9  # a line without length has no normal of its own
    return np.where(point[:, None], outwards, normal * np.sign(sign)[:, None])


def second_is_far(crossings: Crossings) -> NDArray[np.bool_]:
    """(n,) where the second pixel sees the farther surface; nothing is farther than anything."""
    far = np.where(np.isnan(crossings.depths), np.inf, crossings.depths)
    return far[:, 1] > far[:, 0]


def nearest_points(lines: Lines, pixels: Image) -> tuple[Image, Indices, Image]:
    """The point of the lines nearest to each pixel (n, 2) [px], its line, and the share of the line before it."""
    from scipy.spatial import cKDTree

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
