# mypy: ignore-errors
"""First look at a depth image: drop what is no depth, and give memory to the blocks around what was measured."""

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.lanes import eight
from fusion.geometry.pose import Array
from fusion.volume.blocks import F32, F32_2, I32, I64, Blocks, lookup, pack, unpack
from fusion.volume.frame import CELL, PAD, TILE, Work
from fusion.volume.lens import rows
from fusion.volume.settings import BLOCK, LATTICE

FILTER = 1 << 15  # entries of the table that keeps most doublets out of the list of missing blocks


def allocate(
    blocks: Blocks, images: tuple[NDArray[np.float32], NDArray[np.float32]], frame: Work, camera: Camera,
    T_world_camera: Array,
) -> NDArray[np.int32]:  # fmt: skip
    """Add the blocks within the truncation of the measured points; returns those added (n, 3).

    Args:
        blocks: changed in place.
        images: depth (h, w), weight (h, w) or (1, 1).
        frame: its inverse and farthest are filled, and its weight where there is any.
        camera, T_world_camera: as above.

    Raises:
        VolumeError: they do not fit; none is added then.
    """
    settings = blocks.settings
    block = settings.voxel * BLOCK
    box = np.array([-1e30] * 3 + [1e30] * 3 if settings.bounds is None else np.ravel(settings.bounds)) / block
    edge = LATTICE - 2  # neighbours stay on the lattice
    span = np.clip(np.floor(box), -edge, edge).astype(np.int32)
    seen, missing, size = np.full(FILTER, -1, np.int64), np.zeros(1, np.int32), 1 << 14
    depth, weight = images
    horizon = block * (LATTICE - 4)
    weighted = weight.size > 1 or depth.size == 1
    _clean(depth, weight, frame.inverse, frame.weight, frame.layout.stride // 8, horizon, weighted)
    while True:
        keys = np.empty(size, np.int64)
        missing[0] = 0
        _scan(
            frame.inverse, frame.farthest, frame.x, frame.y, rows(T_world_camera), span, blocks.keys, blocks.ids,
            seen, keys, missing, settings.voxel, settings.truncation, camera.fx, frame.margin, *camera.shape,
        )  # fmt: skip
        if missing[0] <= size:
            break
        size, seen = int(missing[0]) * 2, np.full(FILTER, -1, np.int64)
    added = unpack(np.unique(keys[: missing[0]]))
    if len(added):
        blocks.insert(added)
    return added


@ti.func
def _want(
    x: ti.i32, y: ti.i32, z: ti.i32, keys: ti.template(), ids: ti.template(), seen: ti.template(),
    missing: ti.template(), count: ti.template(),
):  # fmt: skip
    """Lists a block when it is absent; a block is looked up once in most cases."""
    key = pack(x, y, z)
    h = ti.cast((key ^ (key >> 16) ^ (key >> 33)) & (FILTER - 1), ti.i32)
    if seen[h] != key:
        seen[h] = key
        if lookup(x, y, z, keys, ids) < 0:
            n = ti.atomic_add(count[0], 1)
            if n < missing.shape[0]:
                missing[n] = key


@ti.func
def _bits(low: ti.template(), high: ti.template()):
    """The blocks from low to high, each of them 0 to 3, as bits 16 x + 4 y + z."""
    one = ti.cast(1, ti.i64)
    bits = one
    for a in ti.static(range(3)):  # axis by axis: what is marked so far, at every step from low to high
        shift = ti.static((16, 4, 1)[a])
        bits <<= shift * low[a]
        bits |= ti.select(high[a] > low[a], bits << shift, 0)
        bits |= ti.select(high[a] > low[a] + 1, bits << (shift * (high[a] - low[a] - 1)), 0)
    return bits


@ti.kernel
def _clean(depth: F32_2, weight: F32_2, inverse: F32, weighed: F32, across: ti.i32, horizon: ti.f32,
           weighted: ti.template()):  # fmt: skip
    """One over depth, and weights, of whole rows of eight pixels."""
    height, width = depth.shape[0], depth.shape[1]
    per_row = (width + TILE - 1) // TILE
    for n in range(height * per_row):
        v, u = n // per_row, n % per_row * TILE
        g = (v + PAD) * across + n % per_row
        z = ti.Vector([depth[v, ti.min(u + e, width - 1)] for e in ti.static(range(8))])
        i = ti.select((z > 1e-6) & (z < horizon), 1.0 / z, 0.0)  # NaN is neither
        if ti.static(weighted):
            w = ti.Vector([weight[v, ti.min(u + e, width - 1)] for e in ti.static(range(8))])
            i = ti.select((w > 0.0) & (w < 1e30), i, 0.0)
            for e in ti.static(range(8)):
                weighed[(g << 3) | e] = w[e]
        if u + TILE > width:
            for e in ti.static(range(8)):
                i[e] = ti.select(u + e < width, i[e], 0.0)
        for e in ti.static(range(8)):
            inverse[(g << 3) | e] = i[e]


@ti.kernel
def _scan(
    inverse: F32, farthest: F32_2, x: F32, y: F32, pose: F32, span: I32, keys: I64, ids: I32, seen: I64, missing: I64,
    count: I32, voxel: ti.f32, truncation: ti.f32, focal: ti.f32, margin: ti.f32, height: ti.i32, width: ti.i32,
):  # fmt: skip
    """Fills `farthest`, and lists absent blocks that hold a voxel which a pixel sees within the truncation."""
    across = farthest.shape[1] // 2
    for tile in range(farthest.shape[0] * across // 2):
        v0, g0 = tile // across * TILE + PAD, tile % across
        corner = ti.Vector([1 << 30, 0, 0])  # of 4 x 4 x 4 blocks, most often all that a tile meets: met once,
        met = ti.cast(0, ti.i64)  # as a bit, they are looked up once
        for half in range(2):
            near8, far8 = ti.Vector([0.0] * 8), ti.Vector([1e30] * 8)  # one over the depths
            for v in ti.static(range(CELL)):
                i = eight(inverse, (v0 + half * CELL + v) * across + g0)
                near8 = ti.select(i > near8, i, near8)
                i = ti.select(i > 0.0, i, 1e30)
                far8 = ti.select(i < far8, i, far8)
            for side in ti.static(range(2)):
                nearest, remote = 0.0, 1e30
                for e in ti.static(range(CELL)):
                    nearest = ti.max(nearest, near8[side * CELL + e])
                    remote = ti.min(remote, far8[side * CELL + e])
                farthest[tile // across * 2 + half, tile % across * 2 + side] = ti.select(
                    nearest > 0.0, 1.0 / remote, 0.0
                )
                if nearest > 0.0:
                    # a cell is looked at as one where it is small and all on one surface, else pixel by pixel
                    size = CELL
                    if nearest - remote > 4.0 * voxel * nearest * remote or CELL > 4.0 * voxel * focal * remote:  # noqa: SIM300
                        size = 1
                    for s in range(CELL // size * (CELL // size)):
                        vb, ub = half * CELL + s // (CELL // size), side * CELL + s % (CELL // size)
                        at = ((v0 + vb) * across + g0) * 8 + ub
                        if size == 1:
                            nearest = inverse[at]
                            remote = nearest
                        if nearest > 0.0:
                            down = ti.min(size - 1, height - 1 - (v0 - PAD + vb))
                            right = ti.min(size - 1, width - 1 - (g0 * 8 + ub))
                            end = at + down * across * 8 + right
                            low, high = _span(
                                ti.Vector([x[at], x[end], y[at], y[end]]), 1.0 / nearest - truncation,
                                1.0 / remote + truncation, margin, pose, span, voxel,
                            )  # fmt: skip
                            if (high - low).min() >= 0:
                                if corner[0] == 1 << 30:
                                    corner = low - 1
                                a, b = low - corner, high - corner
                                if a.min() >= 0 and b.max() < 4:
                                    met |= _bits(a, b)
                                else:
                                    sides = high - low + 1
                                    for j, k, m in ti.ndrange(sides[0], sides[1], sides[2]):
                                        _want(
                                            low[0] + j, low[1] + k, low[2] + m, keys, ids, seen, missing, count
                                        )  # fmt: skip
        for i in range(4):
            slab = ti.cast((met >> 16 * i) & 0xFFFF, ti.i32)
            if slab != 0:
                for b in range(16):
                    if (slab >> b) & 1 == 1:
                        _want(corner[0] + i, corner[1] + b // 4, corner[2] + b % 4, keys, ids, seen, missing, count)


@ti.func
def _span(
    rim: ti.template(), z0: ti.f32, z1: ti.f32, margin: ti.f32, pose: ti.template(), span: ti.template(),
    voxel: ti.f32,
):  # fmt: skip
    """Lowest and highest block around what lies between two depths behind pixels whose centres have x/z and y/z
    within rim (first x, last x, first y, last y), widened by a margin."""
    dx, dy = (0.5 * ti.abs(rim[1] - rim[0]) + margin) * z1, (0.5 * ti.abs(rim[3] - rim[2]) + margin) * z1
    low, high = ti.Vector([0, 0, 0]), ti.Vector([0, 0, 0])
    for a in ti.static(range(3)):
        d = pose[4 * a] * (0.5 * (rim[0] + rim[1])) + pose[4 * a + 1] * (0.5 * (rim[2] + rim[3])) + pose[4 * a + 2]
        wide = ti.abs(pose[4 * a]) * dx + ti.abs(pose[4 * a + 1]) * dy
        p, q = d * z0, d * z1
        first = (pose[4 * a + 3] + ti.min(p, q) - wide) / voxel
        last = (pose[4 * a + 3] + ti.max(p, q) + wide) / voxel
        # blocks that hold a voxel in between; a hundredth for rounding
        low[a] = ti.max(ti.ceil(first - 0.01, ti.i32) >> 3, span[a])
        high[a] = ti.min(ti.floor(last + 0.01, ti.i32) >> 3, span[3 + a])
    return low, high
