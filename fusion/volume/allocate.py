# mypy: ignore-errors
"""First look at a depth image: drop what is no depth, and give memory to the blocks around what was measured."""

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array
from fusion.volume.blocks import F32, F32_2, F32_3, I32, I64, Blocks, lookup, pack, unpack
from fusion.volume.lens import rows
from fusion.volume.settings import BLOCK, LATTICE

TILE = 8  # pixels along the edge of a tile, the unit of the first pass
FILTER = 1 << 15  # entries of the table that keeps most doublets out of the list of missing blocks


def allocate(
    blocks: Blocks, buffers: tuple[NDArray[np.float32], ...], camera: Camera, T_world_camera: Array
) -> NDArray[np.int32]:
    """Add the blocks within the truncation of the measured points; returns those added (n, 3).

    Args:
        blocks: changed in place.
        buffers: depth (h, w), weight (h, w) or (1, 1), then two to be filled: the depth with 0 where missing (h, w)
            and the largest depth of each tile (ceil(h / 8), ceil(w / 8)).
        camera, T_world_camera: as above.

    Raises:
        VolumeError: they do not fit; none is added then.
    """
    settings = blocks.settings
    block = settings.voxel * BLOCK
    box = np.array([-1e30] * 3 + [1e30] * 3 if settings.bounds is None else np.ravel(settings.bounds), np.float32)
    edge = LATTICE - 2  # neighbours stay on the lattice
    span = np.clip(np.floor(box.astype(float) / block), -edge, edge).astype(np.int32)
    seen, missing, size = np.full(FILTER, -1, np.int64), np.zeros(1, np.int32), 1 << 14
    while True:
        keys = np.empty(size, np.int64)
        missing[0] = 0
        _scan(
            *buffers, camera.rays(), rows(T_world_camera), box, span, blocks.keys, blocks.ids, seen, keys, missing,
            settings.voxel, settings.truncation, camera.fx, buffers[1].size > 1 or buffers[0].size == 1,
        )  # fmt: skip
        if missing[0] <= size:
            break
        size, seen = int(missing[0]) * 2, np.full(FILTER, -1, np.int64)
    added = unpack(np.unique(keys[: missing[0]]))
    if len(added):
        blocks.insert(added)
    return added


@ti.func
def _touch(
    p: ti.template(), pad: ti.f32, span: ti.template(), keys: ti.template(), ids: ti.template(), seen: ti.template(),
    missing: ti.template(), count: ti.template(), last: ti.i64,
):  # fmt: skip
    """Lists the absent blocks around a point p [blocks]; `last` and the result are the block looked up last."""
    latest = last
    low = ti.floor(p - pad)
    high = ti.floor(p + pad)
    if low.min() > -LATTICE and high.max() < LATTICE:
        a = ti.cast(low, ti.i32)
        b = ti.cast(high, ti.i32)
        for x in range(ti.max(a[0], span[0]), ti.min(b[0], span[3]) + 1):
            for y in range(ti.max(a[1], span[1]), ti.min(b[1], span[4]) + 1):
                for z in range(ti.max(a[2], span[2]), ti.min(b[2], span[5]) + 1):
                    key = pack(x, y, z)
                    if key != latest:
                        latest = key
                        if lookup(x, y, z, keys, ids) < 0:
                            h = ti.cast((key ^ (key >> 16) ^ (key >> 33)) & (FILTER - 1), ti.i32)
                            if seen[h] != key:
                                seen[h] = key
                                n = ti.atomic_add(count[0], 1)
                                if n < missing.shape[0]:
                                    missing[n] = key
    return latest


@ti.kernel
def _scan(
    depth: F32_2, weight: F32_2, clean: F32_2, farthest: F32_2, rays: F32_3, pose: F32, box: F32, span: I32,
    keys: I64, ids: I32, seen: I64, missing: I64, count: I32,
    voxel: ti.f32, truncation: ti.f32, focal: ti.f32, weighted: ti.template(),
):  # fmt: skip
    height, width = depth.shape[0], depth.shape[1]
    across = farthest.shape[1]
    block = voxel * BLOCK
    reach = ti.min(2.0 * voxel, truncation)  # every sample stands for the cube of this half edge around it
    half = truncation - reach
    samples = ti.cast(ti.ceil(half / reach - 1e-3), ti.i32) + 1
    horizon = block * (LATTICE - 4)
    for tile in range(farthest.shape[0] * across):
        v0 = tile // across * TILE
        u0 = tile % across * TILE
        v1 = ti.min(v0 + TILE, height)
        u1 = ti.min(u0 + TILE, width)
        far = 0.0
        for v in range(v0, v1):
            for u in range(u0, u1):
                z = depth[v, u]
                if not (z > 0.0 and z < horizon):  # also what is NaN
                    z = 0.0
                if ti.static(weighted):
                    w = weight[v, u]
                    if not (w > 0.0 and w < 1e30):
                        z = 0.0
                clean[v, u] = z
                far = ti.max(far, z)
        farthest[tile // across, tile % across] = far
        if far > 0.0:
            R = ti.Matrix([[pose[0], pose[1], pose[2]], [pose[4], pose[5], pose[6]], [pose[8], pose[9], pose[10]]])
            t = ti.Vector([pose[3], pose[7], pose[11]])
            stride = ti.max(1, ti.min(TILE, ti.cast(reach * focal / far, ti.i32)))
            last = ti.cast(-1, ti.i64)
            cells = (TILE + stride - 1) // stride
            for cell in range(cells * cells):
                va = v0 + cell // cells * stride
                ua = u0 + cell % cells * stride
                done = -1e30
                for v in range(va, ti.min(va + stride, v1)):
                    for u in range(ua, ti.min(ua + stride, u1)):
                        z = clean[v, u]
                        if z > 0.0 and ti.abs(z - done) > reach:
                            done = z
                            ray = R @ ti.Vector([rays[v, u, 0], rays[v, u, 1], 1.0])
                            p = ray * z + t
                            if (
                                p[0] >= box[0] and p[1] >= box[1] and p[2] >= box[2]
                                and p[0] <= box[3] and p[1] <= box[4] and p[2] <= box[5]
                            ):  # fmt: skip
                                for s in range(samples):
                                    shift = 0.0
                                    if samples > 1:
                                        shift = half * (2.0 * s / (samples - 1) - 1.0)
                                    last = _touch(
                                        (p + ray * shift) / block, reach / block, span, keys, ids, seen, missing,
                                        count, last,
                                    )  # fmt: skip
