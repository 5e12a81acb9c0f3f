# mypy: ignore-errors
"""First look at a depth image: drop what is no depth, and give memory to the blocks around what was measured."""

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array
from fusion.volume.blocks import F32, F32_2, I32, I64, Blocks, lookup, pack, unpack
from fusion.volume.frame import PAD, TILE, Work
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
        frame: its depth and farthest are filled.
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
    while True:
        keys = np.empty(size, np.int64)
        missing[0] = 0
        _scan(
            *images, frame.depth, frame.farthest, frame.x, frame.y, rows(T_world_camera), box.astype(np.float32), span,
            blocks.keys, blocks.ids, seen, keys, missing, settings.voxel, settings.truncation, camera.fx,
            frame.layout.stride, images[1].size > 1 or images[0].size == 1,
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
    x: ti.i32, y: ti.i32, z: ti.i32, span: ti.template(), keys: ti.template(), ids: ti.template(), seen: ti.template(),
    missing: ti.template(), count: ti.template(),
):  # fmt: skip
    """Lists a block when it is absent and within the bounds."""
    if (
        x >= span[0] and y >= span[1] and z >= span[2] and x <= span[3] and y <= span[4] and z <= span[5]
        and lookup(x, y, z, keys, ids) < 0
    ):  # fmt: skip
        key = pack(x, y, z)
        h = ti.cast((key ^ (key >> 16) ^ (key >> 33)) & (FILTER - 1), ti.i32)
        if seen[h] != key:
            seen[h] = key
            n = ti.atomic_add(count[0], 1)
            if n < missing.shape[0]:
                missing[n] = key


@ti.func
def _bits(low: ti.template(), high: ti.template()):
    """The blocks from low to high, each of them 0 to 3 and at most one apart, as bits 16 x + 4 y + z."""
    one = ti.cast(1, ti.i64)
    column = (one << low[2]) | (one << high[2])
    slab = (column << 4 * low[1]) | (column << 4 * high[1])
    return (slab << 16 * low[0]) | (slab << 16 * high[0])


@ti.kernel
def _scan(
    depth: F32_2, weight: F32_2, clean: F32, farthest: F32_2, x: F32, y: F32, pose: F32, box: F32, span: I32,
    keys: I64, ids: I32, seen: I64, missing: I64, count: I32,
    voxel: ti.f32, truncation: ti.f32, focal: ti.f32, stride: ti.i32, weighted: ti.template(),
):  # fmt: skip
    height, width = depth.shape[0], depth.shape[1]
    across = farthest.shape[1]
    block = voxel * BLOCK
    reach = ti.min(2.0 * voxel, truncation)  # every sample stands for the cube of this half edge around it
    half = truncation - reach
    samples = ti.cast(ti.ceil(half / reach - 1e-3), ti.i32) + 1
    spacing = 0.0  # between samples along a ray, where both ends are 1 apart; a single one sits in the middle
    if samples > 1:
        spacing = 1.0 / (samples - 1)
    else:
        half = 0.0
    horizon = block * (LATTICE - 4)
    for tile in range(farthest.shape[0] * across):
        v0 = tile // across * TILE
        u0 = tile % across * TILE
        v1 = ti.min(v0 + TILE, height)
        u1 = ti.min(u0 + TILE, width)
        far = 0.0
        before = farthest[tile // across, tile % across]
        for v in range(v0, v1):
            for u in range(u0, u1):
                z = depth[v, u]
                far = ti.select((z > far) & (z < horizon), z, far)  # not what is NaN
        if far > 0.0 or before > 0.0:  # else the tile is empty and stays so
            far = 0.0
            for v in range(v0, v1):
                for u in range(u0, u1):
                    z = depth[v, u]
                    good = (z > 0.0) & (z < horizon)
                    if ti.static(weighted):
                        good &= (weight[v, u] > 0.0) & (weight[v, u] < 1e30)
                    z = ti.select(good, z, 0.0)
                    clean[(v + PAD) * stride + u] = z
                    far = ti.select(z > far, z, far)
        farthest[tile // across, tile % across] = far
        if far > 0.0:
            R = (
                ti.Matrix([[pose[0], pose[1], pose[2]], [pose[4], pose[5], pose[6]], [pose[8], pose[9], pose[10]]])
                / block
            )
            t = ti.Vector([pose[3], pose[7], pose[11]]) / block
            # pixels along the edge of a square whose first one stands for all of like depth
            cell = ti.max(1, ti.min(TILE, ti.cast(reach * focal / far, ti.i32)))
            cells = (TILE + cell - 1) // cell
            corner = ti.Vector([1 << 30, 0, 0])  # of 4 x 4 x 4 blocks, most often all that a tile meets: met once,
            met = ti.cast(0, ti.i64)  # as a bit, they are looked up once
            for c in range(cells * cells):
                va = v0 + c // cells * cell
                ua = u0 + c % cells * cell
                done = -1e30
                for v in range(va, ti.min(va + cell, v1)):
                    for u in range(ua, ti.min(ua + cell, u1)):
                        at = (v + PAD) * stride + u
                        z = clean[at]
                        if z > 0.0 and ti.abs(z - done) > reach:
                            done = z
                            ray = R @ ti.Vector([x[at], y[at], 1.0])
                            p = ray * z + t  # [blocks]
                            if (
                                p[0] >= box[0] and p[1] >= box[1] and p[2] >= box[2]
                                and p[0] <= box[3] and p[1] <= box[4] and p[2] <= box[5]
                            ):  # fmt: skip
                                for s in range(samples):
                                    shift = (2.0 * s * spacing - 1.0) * half
                                    a = ti.floor(p + ray * shift - reach / block, ti.i32)
                                    b = ti.floor(p + ray * shift + reach / block, ti.i32)
                                    if corner[0] == 1 << 30:
                                        corner = a - 1
                                    a -= corner
                                    b -= corner
                                    if (a | b).min() >= 0 and (a | b).max() < 4:
                                        met |= _bits(a, b)
                                    else:
                                        for i, j, k in ti.ndrange((a[0], b[0] + 1), (a[1], b[1] + 1), (a[2], b[2] + 1)):
                                            _want(
                                                corner[0] + i, corner[1] + j, corner[2] + k, span, keys, ids, seen,
                                                missing, count,
                                            )  # fmt: skip
            for i in range(4):
                slab = ti.cast((met >> 16 * i) & 0xFFFF, ti.i32)
                if slab != 0:
                    for b in range(16):
                        if (slab >> b) & 1 == 1:
                            _want(
                                corner[0] + i, corner[1] + b // 4, corner[2] + b % 4, span, keys, ids, seen,
                                missing, count,
                            )  # fmt: skip
