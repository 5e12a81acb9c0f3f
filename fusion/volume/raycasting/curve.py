# mypy: ignore-errors
"""Depths between rays that were followed, read off the curve through them where the surface is smooth."""

import numpy as np
from numpy.typing import NDArray

from fusion.compute.arrays import F32
from fusion.compute.language import ti
from fusion.geometry.lanes import bounded

PAD = 2  # pixels around an image of rays, in which nothing is seen
SMOOTH = 0.05  # voxels that a bend may move the surface between two rays; then their curve says where it is
STRIP = 16  # pixels of a row that are looked at in turn
INFINITY = 0x7F800000  # as bits, which go up with the number; those of NaN lie above
COARSE = 4  # pixels between the rays that are followed first; those between them mostly meet the same surface


def unseen(height: int, width: int, step: int = 1) -> NDArray[np.float32]:
    """Depths of every step-th ray in both directions, none known yet, NaN; rows are whole strips at any step."""
    across = -(-width // (COARSE * STRIP)) * COARSE * STRIP // step
    return np.full((-(-height // step) + 2 * PAD, across + 2 * PAD), np.nan, np.float32)


def padded(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """An image (h, w) laid out as the depths of all its rays are."""
    h, w = image.shape
    out = unseen(h, w)
    out[PAD : PAD + h, PAD : PAD + w] = image
    return out


@ti.func
def _half_way(a: ti.template(), b: ti.template(), c: ti.template(), e: ti.template(), voxel: ti.f32, farthest: ti.f32):
    """Depth between b and c on the cubic through four pixels in a line, one over depth taken as smooth; NaN where one
    of them is missing, the curve bends, or b and c lie on two surfaces or too far away."""
    near, far, whole = a * e * (b + c), b * c * (a + e), a * b * c * e
    i = 9.0 * near - far  # 16 * whole / depth; of NaN nothing is true
    smooth = ti.abs(near - far) * whole < 4.0 * SMOOTH * voxel * near * near
    together = (ti.abs(b - c) < 2.0 * voxel) & (2.0 * b * c < farthest * (b + c))
    return ti.select(smooth & together, 16.0 * whole / i, ti.math.nan)


@ti.kernel
def fill(coarse: F32, rows: ti.i32, wide: ti.i32, fine: F32, voxel: ti.f32, farthest: ti.f32):
    """Depths of all rays from those of every second one in both directions, where they lie on a smooth surface nearer
    than `farthest`; the others stay as they are. Both images are padded and flat, the coarse one with `rows` rows of
    `wide` pixels."""
    across = (wide - 2 * PAD) // STRIP
    for n in range((rows - 2 * PAD) * across):
        row, strip = n // across, n % across
        at = (row + PAD) * wide + strip * STRIP + PAD
        above, below, second = bounded(at - wide), bounded(at + wide), bounded(at + 2 * wide)
        at = bounded(at)
        nearest = INFINITY
        for s in range(STRIP):
            nearest = ti.min(nearest, ti.bit_cast(coarse[at + s], ti.i32))
        if nearest < INFINITY:  # loops that the compiler makes vectors of
            right, down, both = ti.Vector([0.0] * STRIP), ti.Vector([0.0] * STRIP), ti.Vector([0.0] * STRIP)
            for s in range(STRIP):
                here = coarse[at + s]
                across_z = _half_way(coarse[at + s - 1], here, coarse[at + s + 1], coarse[at + s + 2], voxel, farthest)
                down_z = _half_way(coarse[above + s], here, coarse[below + s], coarse[second + s], voxel, farthest)
                z = _half_way(
                    coarse[above + s - 1], here, coarse[below + s + 1], coarse[second + s + 2], voxel, farthest
                )  # fmt: skip
                aside = (ti.abs(coarse[at + s + 1] - z) < voxel) & (ti.abs(coarse[below + s] - z) < voxel)
                right[s], down[s], both[s] = across_z, down_z, ti.select(aside, z, ti.math.nan)
            o = 2 * row * (2 * wide - 2 * PAD) + 2 * strip * STRIP + PAD * (2 * wide - 2 * PAD + 1)
            for s in range(STRIP):
                fine[o + 2 * s], fine[o + 2 * s + 1] = coarse[at + s], right[s]
            o += 2 * wide - 2 * PAD
            for s in range(STRIP):
                fine[o + 2 * s], fine[o + 2 * s + 1] = down[s], both[s]
