"""Depth edges of a perfect image: where neither side's slope leads to the neighbour.

Where between two pixels an edge runs cannot be known. Half way, no pixel would ever be cut by one; so the place is
drawn once for all, evenly over the way from pixel to pixel and alike along an edge.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.edges.nearest import REACH_PX, Crossings, Indices, nearest_edges
from fusion.sensor.edges.neighbours import pairs_along, stride_along
from fusion.sensor.effects.readout.lateral_noise import normal_share
from fusion.sensor.laws.fields import frozen_field
from fusion.sensor.view import Edges, Image
from fusion.simulation.ideal.frame import IdealFrame

JUMP = 0.002  # share of the depth: smaller steps are no edge, as where the own simulator looks
BETWEEN = 0.25  # of that, between two segments
ALIKE_PX = 8.0  # over which the drawn places of an edge are alike: guess
STEEPER = 2.0  # times the flatter slope beside it on either side: a silhouette and no bend (as estimate.edges_of)


def edges_of_perfect(frame: IdealFrame, amplitude: Image, reach: float = REACH_PX) -> Edges:
    """The nearest edge of every pixel, as far as `reach` [px].

    Args:
        frame: checked.
        amplitude: (h, w) in any unit: gives the light across an edge.
    """
    depth = frame.depth
    with np.errstate(all="ignore"):
        w = 1 / depth
        pairs = [torn(w, frame, axis) for axis in (1, 0)]
        first, second = (np.concatenate(side) for side in zip(*pairs, strict=True))
        z = depth.reshape(-1)
        places = [_places(w.shape, axis)[pair[0]] for axis, pair in zip((1, 0), pairs, strict=True)]
        crossings = Crossings(first, second, np.concatenate(places), np.column_stack([z[first], z[second]]))
        return nearest_edges(crossings, depth, amplitude, reach)


def torn(w: Image, frame: IdealFrame, axis: int) -> tuple[Indices, Indices]:
    """Indices of neighbours along an axis, and of the ones to the right or below, that are not one surface."""
    flat, stride = w.reshape(-1), stride_along(w, axis)
    step = flat[stride:] - flat[:-stride]
    least = np.float32(JUMP * BETWEEN) * flat[:-stride]
    some = (np.abs(step) > least) & ~calm(step, flat, w.shape, axis, frame.segmentation is not None)
    missing = np.isnan(flat)
    ends = pairs_along(w, axis, missing[stride:] != missing[:-stride])
    first = pairs_along(w, axis, some)
    place = first // stride % w.shape[axis]
    size = len(step)

    def beside(by: int) -> Image:
        inside = (place + by >= 0) & (place + by < w.shape[axis] - 1)
        # beyond the rim, and where nothing is seen, the surface goes on as flat as can be
        return np.where(inside, np.nan_to_num(step[np.clip(first + by * stride, 0, size - 1)]), 0)

    own, before, after = step[first], beside(-1), beside(1)
    flattest = np.maximum(np.minimum(np.abs(before), np.abs(beside(-2))), np.minimum(np.abs(after), np.abs(beside(2))))
    nearer = np.maximum(flat[first], flat[first + stride])
    limit = JUMP * nearer
    if frame.segmentation is not None:
        label = np.asarray(frame.segmentation).reshape(-1)
        limit = np.where(label[first] != label[first + stride], BETWEEN * limit, limit)
    limit = limit + 2 * frame.rounding * nearer**2
    off = np.minimum(np.abs(own - before), np.abs(own - after))
    first = np.sort(np.concatenate([first[(off > limit) & (np.abs(own) > STEEPER * flattest)], ends]))
    if axis == 0:  # column by column
        first = first[np.lexsort((first // stride, first % stride))]
    return first, first + stride


def calm(step: Image, flat: Image, shape: tuple[int, int], axis: int, segmented: bool) -> NDArray[np.bool_]:
    """(n,) steps that go on as one beside them does, by the least that may count: whole images, so that few are left
    for a closer look. None at the rim, and none beside what is missing."""
    stride = 1 if axis == 1 else shape[1]
    limit = np.maximum(flat[:-stride], flat[stride:]) * np.float32(0.999 * JUMP * (BETWEEN if segmented else 1.0))
    alike = np.abs(step[stride:] - step[:-stride])
    goes_on = np.zeros(len(step), bool)
    goes_on[stride:-stride] = np.minimum(alike[:-stride], alike[stride:]) <= limit[stride:-stride]
    full = np.zeros(len(flat), bool)
    full[: len(step)] = goes_on
    image = full.reshape(shape)
    for rim in (np.s_[:1], np.s_[-2:]):
        image[rim if axis == 0 else (slice(None), rim)] = False
    return image.reshape(-1)[: len(step)]


@lru_cache(maxsize=8)
def _places(shape: tuple[int, int], axis: int) -> NDArray[np.float32]:
    """(h w,) where between a pixel and the next along an axis an edge runs [px], evenly from 0 to 1."""
    drawn = normal_share(frozen_field(shape, ALIKE_PX, f"edges along {axis}", 0)).astype(np.float32).reshape(-1)
    drawn.flags.writeable = False
    return drawn
