# mypy: ignore-errors
"""Reading the field between voxels: trilinear value and gradient."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.compute.language import F32, F32_2, I32, I32_2, I64, func, kernel, ti
from fusion.volume.blocks import Blocks, entry
from fusion.volume.hashing import lookup
from fusion.volume.settings import BLOCK, LATTICE


class SampledField(NamedTuple):
    """What of the blocks tells distances, see `Blocks`, and the size of a voxel [m]."""

    keys: I64
    ids: I32
    neighbours: I32_2
    voxels: F32
    voxel: ti.f32


def field(blocks: Blocks) -> SampledField:
    """As kernels take it."""
    return SampledField(
        blocks.arrays.keys, blocks.arrays.ids, blocks.arrays.neighbours, blocks.arrays.flat, blocks.settings.voxel
    )


def sample(blocks: Blocks, points: NDArray[np.float64]) -> tuple[NDArray[np.float32], ...]:
    """Distance, gradient and weight at world points.

    Args:
        blocks: the volume's blocks.
        points: (n, 3) [m].

    Returns:
        Trilinear distance (n,) [m], its gradient (n, 3) and weight (n,): NaN, NaN and 0 where one of the eight
        voxels around was never seen.
    """
    grid = np.asarray(points, float).reshape(-1, 3) / blocks.settings.voxel
    near = (np.abs(grid) < (LATTICE - 2) * BLOCK).all(axis=1)  # False for NaN too
    base = np.floor(np.where(near[:, None], grid, 0.0))
    distance = np.full(len(grid), np.nan, np.float32)
    gradient = np.full((len(grid), 3), np.nan, np.float32)
    weight = np.zeros(len(grid), np.float32)
    if len(grid):
        _sample(
            base.astype(np.int32), np.where(near[:, None], grid - base, np.nan).astype(np.float32), field(blocks),
            distance, gradient, weight,
        )  # fmt: skip
    return distance, gradient, weight


@func
def place(n: ti.i32, i: ti.i32, j: ti.i32, k: ti.i32, neighbours: ti.template()):
    """Block and index of voxel (i, j, k) of block n, each of i, j, k from -8 to 15; block -1 where there is none."""
    block = neighbours[n, (i >> 3) * 9 + (j >> 3) * 3 + (k >> 3) + 13]  # itself, mostly: a look is less than a branch
    return block, ((i & 7) * BLOCK + (j & 7)) * BLOCK + (k & 7)


@func
def value(n: ti.i32, i: ti.i32, j: ti.i32, k: ti.i32, neighbours: ti.template(), voxels: ti.template()):
    """Distance [m] and weight of voxel (i, j, k) of block n; (0, 0) where it was never seen."""
    block, o = place(n, i, j, k, neighbours)
    at = entry(ti.max(block, 0), o)
    weight = ti.select(block >= 0, voxels[at + BLOCK], 0.0)
    return ti.select(weight > 0.0, voxels[at] / weight, 0.0), weight


@func
def corners(n: ti.i32, i: ti.i32, j: ti.i32, k: ti.i32, neighbours: ti.template(), voxels: ti.template()):
    """Distances (8,) of the cell whose lowest corner is voxel (i, j, k), 0 to 7, of block n, and the lowest weight;
    all 0 where that is 0."""
    at = ti.Vector([0] * 8)
    known = True
    if ti.max(i, j, k) < BLOCK - 1:  # all in one block
        first = entry(n, (i * BLOCK + j) * BLOCK + k)
        at = first + ti.Vector([o // 4 * 128 + o // 2 % 2 * 16 + o % 2 for o in range(8)])
    else:
        for o in range(8):
            block, voxel = place(n, i + o // 4, j + o // 2 % 2, k + o % 2, neighbours)
            known = known and block >= 0
            at[o] = entry(ti.max(block, 0), voxel)
    f = ti.Vector([0.0] * 8)
    lowest = 0.0
    if known:
        w = ti.Vector([voxels[at[o] + BLOCK] for o in ti.static(range(8))])
        lowest = w.min()
        if lowest > 0.0:
            f = ti.Vector([voxels[at[o]] for o in ti.static(range(8))]) / w
    return f, lowest


@func
def blend(f: ti.template(), a: ti.template()):
    """Trilinear value of corner values f (8,) at a (3,), 0 to 1."""
    x = ti.Vector([f[o] + (f[o + 4] - f[o]) * a[0] for o in ti.static(range(4))])
    y0 = x[0] + (x[2] - x[0]) * a[1]
    y1 = x[1] + (x[3] - x[1]) * a[1]
    return y0 + (y1 - y0) * a[2]


@func
def slope(f: ti.template(), a: ti.template()):
    """Gradient (3,) of the trilinear value per cell."""
    x = ti.Vector([f[o] + (f[o + 4] - f[o]) * a[0] for o in ti.static(range(4))])
    d = ti.Vector([f[o + 4] - f[o] for o in ti.static(range(4))])
    d0 = d[0] + (d[2] - d[0]) * a[1]
    d1 = d[1] + (d[3] - d[1]) * a[1]
    y0 = x[0] + (x[2] - x[0]) * a[1]
    y1 = x[1] + (x[3] - x[1]) * a[1]
    e0 = x[2] - x[0]
    e1 = x[3] - x[1]
    return ti.Vector([d0 + (d1 - d0) * a[2], e0 + (e1 - e0) * a[2], y1 - y0])


@func
def smooth(
    n: ti.i32, cell: ti.template(), a: ti.template(), f: ti.template(), neighbours: ti.template(),
    voxels: ti.template(),
):  # fmt: skip
    """Gradient (3,) [m per voxel] at a (3,), 0 to 1, of a cell (3,) with the corner values f (8,), blended from
    central differences at its corners.

    Half as noisy as the slope within the cell and continuous from cell to cell; (0, 0, 0) where a voxel is unknown.
    """
    g = ti.Vector([0.0, 0.0, 0.0])
    known = True
    for axis in ti.static(range(3)):
        one, other = ti.static((axis + 1) % 3, (axis + 2) % 3)
        for q in range(4):  # the four edges along the axis; written out they would take long to load from the cache
            c = (q // 2) * ti.static(4 >> one) + (q % 2) * ti.static(4 >> other)
            at = ti.Vector([cell[0] + c // 4, cell[1] + c // 2 % 2, cell[2] + c % 2])
            step = ti.Vector([axis == 0, axis == 1, axis == 2])
            low, high = at - step, at + 2 * step
            before, w0 = value(n, low[0], low[1], low[2], neighbours, voxels)
            after, w1 = value(n, high[0], high[1], high[2], neighbours, voxels)
            known = known and ti.min(w0, w1) > 0.0
            part = ti.select(q // 2 == 1, a[one], 1.0 - a[one]) * ti.select(q % 2 == 1, a[other], 1.0 - a[other])
            here, there = f[c], f[c | ti.static(4 >> axis)]
            rise = there - before
            g[axis] += 0.5 * part * (rise + (after - here - rise) * a[axis])
    if not known:
        g = ti.Vector([0.0, 0.0, 0.0])
    return g


@kernel
def _sample(base: I32_2, part: F32_2, field: SampledField, distance: F32, gradient: F32_2, weight: F32):
    """Fills in what is known at places of cells."""
    for p in range(base.shape[0]):
        a = ti.Vector([part[p, 0], part[p, 1], part[p, 2]])
        if a[0] == a[0]:
            i, j, k = base[p, 0], base[p, 1], base[p, 2]
            n = lookup(i >> 3, j >> 3, k >> 3, field.keys, field.ids)
            if n >= 0:
                f, lowest = corners(n, i & 7, j & 7, k & 7, field.neighbours, field.voxels)
                if lowest > 0.0:
                    distance[p] = blend(f, a)
                    g = slope(f, a) / field.voxel
                    for axis in ti.static(range(3)):
                        gradient[p, axis] = g[axis]
                    weight[p] = lowest
