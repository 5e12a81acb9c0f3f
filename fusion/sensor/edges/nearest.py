"""From depth jumps between neighbouring pixels to the nearest edge of every pixel."""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.compute.start import start
from fusion.sensor.view import Edges, Image

REACH_PX = 8.0
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class Crossings:
    """Where an edge passes between two neighbouring pixels."""

    # first, second: (n,) indices of the pixels in the raveled image; the second is to the right or below
    first: Indices
    second: Indices
    position: Image  # (n,) share of the way from the first to the second
    depths: Image  # (n, 2) [m] at the edge, on the side of the first and of the second; NaN where there is nothing


def nearest_edges(crossings: Crossings, depth: Image, amplitude: Image, reach: float = REACH_PX) -> Edges:
    """The edge that is nearest to each pixel, at most `reach` [px] away.

    An edge beside one with a jump three times as large is left out. Crossings of one 2 x 2 cell are joined to lines,
    so that distances to a straight edge are exact.

    Args:
        depth, amplitude: (h, w) of the pixels; the amplitude in any unit.
    """
    images = tuple(np.full(depth.shape, value, np.float32) for value in (np.inf, 0.0, 0.0, 1.0))
    if not len(crossings.first):
        return Edges(*images)
    from fusion.sensor.edges import edge_kernels as kernels  # starts Taichi

    start()
    pairs = np.column_stack([crossings.first, crossings.second]).astype(np.int32)
    points, links = _laid_out(crossings, depth.shape)
    depths = np.ascontiguousarray(crossings.depths, np.float32)
    jumps = np.nan_to_num(np.abs(depths[:, 1] - depths[:, 0]), nan=np.inf)
    weak = np.zeros(len(points), np.int32)
    kernels.overshadowed(links, pairs, points, jumps, weak)
    margin = int(reach) + 1  # cells beyond the image hold nothing, and need not be told from others
    held = np.zeros((depth.shape[0] + 1 + 2 * margin, depth.shape[1] + 1 + 2 * margin), np.int32)
    lines, ends = np.empty((8 * len(points), 4), np.float32), np.empty((8 * len(points), 2), np.int32)
    kernels.join_crossings(links, pairs, points, weak, margin, held, lines, ends)
    near, off = _near(pairs[weak == 0], depth.shape, reach)
    rings, pieces = kernels.Rings(*_rings(margin), margin), kernels.Pieces(held, lines, ends)
    own = kernels.Own(*(np.ascontiguousarray(image, np.float32).reshape(-1) for image in (depth, amplitude)))
    out = kernels.EdgeImages(*(image.reshape(-1) for image in images))
    kernels.look_across(near, off, reach, rings, pieces, kernels.Crossed(pairs, depths), own, out)
    return Edges(*images)


def _laid_out(crossings: Crossings, shape: tuple[int, ...]) -> tuple[Image, NDArray[np.int32]]:
    """Points (n, 2) [px, u v] of the crossings, and their numbers at the links that they are on."""
    v, u = np.divmod(crossings.first, shape[1])
    right = crossings.second == crossings.first + 1
    points = np.column_stack([u + np.where(right, crossings.position, 0), v + np.where(right, 0, crossings.position)])
    height, width = shape
    links = np.full((2, height + 2, width + 2), -1, np.int32)
    links.reshape(-1)[(~right * (height + 2) + v + 1) * (width + 2) + u + 1] = np.arange(len(v))
    return points.astype(np.float32), links


def _near(pairs: NDArray[np.int32], shape: tuple[int, ...], reach: float) -> tuple[NDArray[np.int32], Image]:
    """Flat indices (n,) of the pixels that may have an edge within reach, and how far pixels beside one are [px]."""
    beside = np.ones(shape, np.uint8)
    beside.reshape(-1)[pairs] = 0
    away = cv2.distanceTransform(beside, cv2.DIST_L2, cv2.DIST_MASK_5).reshape(-1)
    near = np.flatnonzero(away <= reach)
    return near.astype(np.int32), np.asarray(away[near], np.float32)


@lru_cache(maxsize=8)
def _rings(most: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Cells around a pixel up to `most` [px] away, the nearest first, as kernels take them; read only.

    Returns:
        (n, 3) square of the distance [px^2], row and column; and (most^2 + 1,) the first that is as far.
    """
    # the four cells around a pixel are 0 px away, and numbered 0 and 1
    steps = np.arange(-most, most + 2)
    away = np.where(steps > 0, steps - 1, -steps)
    square = away[:, None] ** 2 + away[None, :] ** 2
    order = np.argsort(square, axis=None, kind="stable")
    order = order[: np.searchsorted(square.reshape(-1)[order], most**2, side="right")]
    rows, columns = np.divmod(order, len(steps))
    rings = np.column_stack([square.reshape(-1)[order], steps[rows], steps[columns]]).astype(np.int32)
    begins = np.searchsorted(rings[:, 0], np.arange(most**2 + 1)).astype(np.int32)
    rings.flags.writeable = begins.flags.writeable = False
    return rings, begins
