# mypy: ignore-errors
"""Depths between rays that were followed, read off the curve through them where the surface is smooth."""

import numpy as np
from numpy.typing import NDArray

from fusion.compute.language import ti
from fusion.volume.blocks import F32_2

PAD = 2  # pixels around an image of rays, in which nothing is seen
SMOOTH = 0.05  # voxels that a bend may move the surface between two rays; then their curve says where it is
STRIP = 16  # pixels of a row that are looked at in turn
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
def fill(coarse: F32_2, fine: F32_2, voxel: ti.f32, farthest: ti.f32):
    """Depths of all rays from those of every second one in both directions, where they lie on a smooth surface nearer
    than `farthest`; the others stay as they are. Both images are padded."""
    across = (coarse.shape[1] - 2 * PAD) // STRIP
    for n in range((coarse.shape[0] - 2 * PAD) * across):
        r, c = n // across + PAD, n % across * STRIP + PAD
        some = False
        for s in range(STRIP):
            some |= coarse[r, c + s] > 0.0
        if some:  # loops that the compiler makes vectors of
            right, down, both = ti.Vector([0.0] * STRIP), ti.Vector([0.0] * STRIP), ti.Vector([0.0] * STRIP)
            for s in range(STRIP):
                u = c + s
                right[s] = _half_way(
                    coarse[r, u - 1], coarse[r, u], coarse[r, u + 1], coarse[r, u + 2], voxel, farthest
                )  # fmt: skip
                down[s] = _half_way(
                    coarse[r - 1, u], coarse[r, u], coarse[r + 1, u], coarse[r + 2, u], voxel, farthest
                )  # fmt: skip
            for s in range(STRIP):
                u = c + s
                z = _half_way(
                    coarse[r - 1, u - 1], coarse[r, u], coarse[r + 1, u + 1], coarse[r + 2, u + 2], voxel, farthest
                )  # fmt: skip
                aside = (ti.abs(coarse[r, u + 1] - z) < voxel) & (ti.abs(coarse[r + 1, u] - z) < voxel)
                both[s] = ti.select(aside, z, ti.math.nan)
            v, u = 2 * (r - PAD) + PAD, 2 * (c - PAD) + PAD
            for s in range(STRIP):
                fine[v, u + 2 * s], fine[v, u + 2 * s + 1] = coarse[r, c + s], right[s]
                fine[v + 1, u + 2 * s], fine[v + 1, u + 2 * s + 1] = down[s], both[s]
