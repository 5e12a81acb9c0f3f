# mypy: ignore-errors
"""Depths between rays that were followed, read off the curve through them where the surface is smooth."""

import numpy as np
from numpy.typing import NDArray

from fusion.compute.language import func, ti
from fusion.volume.raycasting.image_pool import PIECE
from fusion.volume.raycasting.window import TILE

PAD = 2  # pixels around an image of rays, in which nothing is seen
SMOOTH = 0.05  # voxels that a bend may move the surface between two rays; then their curve says where it is
SQUARE = 16  # rays of a square that are looked at in turn, as many as one of TILE holds of every second one
INFINITY = 0x7F800000  # as bits, which go up with the number; those of NaN lie above
COARSE = 4  # pixels between the rays that are followed first; those between them mostly meet the same surface


def unseen(height: int, width: int, step: int = 1) -> NDArray[np.float32]:
    """Depths of every step-th ray in both directions, none known yet, NaN; of whole tiles, in rows of whole pieces."""
    down, across = -(-height >> TILE) << TILE, -(-width // PIECE) * PIECE
    return np.full((down // step + 2 * PAD, across // step + 2 * PAD), np.nan, np.float32)


def padded(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """An image (h, w) laid out as the depths of all its rays are."""
    h, w = image.shape
    out = unseen(h, w)
    out[PAD : PAD + h, PAD : PAD + w] = image
    return out


@func
def _half_way(a: ti.template(), b: ti.template(), c: ti.template(), e: ti.template(), voxel: ti.f32, farthest: ti.f32):
    """Depth between b and c on the cubic through four pixels in a line, one over depth taken as smooth; NaN where one
    of them is missing, the curve bends, or b and c lie on two surfaces or too far away."""
    near, far, whole = a * e * (b + c), b * c * (a + e), a * b * c * e
    i = 9.0 * near - far  # 16 * whole / depth; of NaN nothing is true
    smooth = ti.abs(near - far) * whole < 4.0 * SMOOTH * voxel * near * near
    together = (ti.abs(b - c) < 2.0 * voxel) & (2.0 * b * c < farthest * (b + c))
    return ti.select(smooth & together, 16.0 * whole / i, ti.math.nan)


@func
def fill(i: ti.i32, j: ti.i32, side: ti.i32, depths: ti.template(), voxel: ti.f32):
    """Depths of those rays of a tile that lie on a smooth surface nearer than `farthest`; the others are NaN. (i, j) is
    its first one in the padded image `coarse` of every second ray in both directions, which has `side` of them along
    the tile's edge, 4 or 2."""
    coarse, fine, farthest = ti.static((depths.coarse, depths.fine, depths.farthest))
    nearest, last = INFINITY, side - 1  # of a smaller tile, rays are looked at again and again
    here, right = ti.Vector([0.0] * SQUARE), ti.Vector([0.0] * SQUARE)
    down, both = ti.Vector([0.0] * SQUARE), ti.Vector([0.0] * SQUARE)
    for s in range(SQUARE):
        v, u = i + ((s >> 2) & last), j + (s & last)
        z = coarse[v, u]
        nearest, here[s] = ti.min(nearest, ti.bit_cast(z, ti.i32)), z
    if nearest < INFINITY:
        for s in range(SQUARE):  # the compiler makes vectors of it
            v, u = i + ((s >> 2) & last), j + (s & last)
            z, e, d = here[s], coarse[v, u + 1], coarse[v + 1, u]
            right[s] = _half_way(coarse[v, u - 1], z, e, coarse[v, u + 2], voxel, farthest)
            down[s] = _half_way(coarse[v - 1, u], z, d, coarse[v + 2, u], voxel, farthest)
            z = _half_way(coarse[v - 1, u - 1], z, coarse[v + 1, u + 1], coarse[v + 2, u + 2], voxel, farthest)
            both[s] = ti.select((ti.abs(e - z) < voxel) & (ti.abs(d - z) < voxel), z, ti.math.nan)
        for s in range(SQUARE):
            v, u = 2 * (i + ((s >> 2) & last)) - PAD, 2 * (j + (s & last)) - PAD
            fine[v, u], fine[v, u + 1] = here[s], right[s]
            fine[v + 1, u], fine[v + 1, u + 1] = down[s], both[s]
