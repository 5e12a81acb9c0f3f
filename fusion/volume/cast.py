# mypy: ignore-errors
"""Casting the rays of an image: few are followed, most start from those around them."""

import taichi as ti

from fusion.volume.blocks import F32, F32_2, F32_3, I32, I32_2, I64
from fusion.volume.march import march, refine
from fusion.volume.window import TILE

COARSE = 4  # pixels between the rays that are followed first; those between them mostly meet the same surface
SMOOTH = 0.05  # voxels that a bend may move the surface between two rays; then their curve says where it is
SPACING = 3.0  # voxels between rays that are done: what fits between them is too narrow for voxels to hold
SHARES = 32  # of the rays, that threads take in turn


@ti.func
def _expected(depth: ti.template(), v: ti.i32, u: ti.i32, step: ti.i32):
    """Depth of a pixel on the plane through those around that are done, and how much these differ, 0 where one of them
    is missing; and whether one of them is there. Along a line in the image, 1 / z of a plane is linear."""
    height, width = depth.shape[0], depth.shape[1]
    dv = ti.select(v & (2 * step - 1) == 0, 0, step)
    du = ti.select(u & (2 * step - 1) == 0, 0, step)
    z, difference, some = 0.0, 0.0, True
    if v + dv < height and u + du < width:
        a, b = depth[v - dv, u - du], depth[v + dv, u + du]
        c, e = depth[v - dv, u + du], depth[v + dv, u - du]  # the same two unless the pixel lies amid four
        nearest, farthest = ti.min(a, b, c, e), ti.max(a, b, c, e)
        some = a > 0.0 or b > 0.0 or c > 0.0 or e > 0.0
        if a > 0.0 and b > 0.0 and c > 0.0 and e > 0.0:
            z = 4.0 / (1.0 / a + 1.0 / b + 1.0 / c + 1.0 / e)
            difference = farthest - nearest
    return z, difference, some


@ti.func
def _between(depth: ti.template(), v: ti.i32, u: ti.i32, dv: ti.i32, du: ti.i32, most: ti.f32):
    """Depth on the cubic through four pixels in a line, two to either side, one over depth taken as smooth; -1 where
    one is missing or the curve bends by more than `most` [m]."""
    height, width = depth.shape[0], depth.shape[1]
    z = -1.0
    v0, u0, v1, u1 = v - 3 * dv, u - 3 * du, v + 3 * dv, u + 3 * du
    if ti.min(v0, u0, v1, u1) >= 0 and ti.max(v0, v1) < height and ti.max(u0, u1) < width:
        a, b, c, e = depth[v0, u0], depth[v - dv, u - du], depth[v + dv, u + du], depth[v1, u1]
        near, far = a * e * (b + c), b * c * (a + e)
        whole = a * b * c * e
        i = 9.0 * near - far  # 16 * whole / z; of NaN nothing is true
        if ti.abs(near - far) * whole < 4.0 * most * near * near:
            z = 16.0 * whole / i
    return z


@ti.func
def _next(turn: ti.template(), share: ti.i32, total: ti.i32):
    """Where the next share begins; the total when all are taken."""
    begin = total
    if turn[0] < total:  # else it would grow without end
        begin = ti.atomic_add(turn[0], share)
    return begin


@ti.kernel
def cast(
    step: ti.i32, keys: I64, ids: I32, low: I32, size: I32, grid: I32, solid: I32, neighbours: I32_2, voxels: F32,
    rays: F32_3, pose: F32, first: F32_2, last: F32_2, tiles: I32, count: ti.i32, voxel: ti.f32, focal: ti.f32,
    depth: F32_2, turn: I32, parts: ti.i32,
):  # fmt: skip
    """Fills in the depths (NaN before) of every step-th pixel in both directions; those at twice the step are taken as
    done, unless the step is COARSE. What such rays enclose is less than SPACING wide, or else every ray is followed
    from its start; where they all met nothing, neither do those between them."""
    height, width = depth.shape[0], depth.shape[1]
    side = TILE // step
    bits = ti.select(side == TILE, 3, ti.select(side == 4, 2, 1))  # divisions would take as long as the rest
    total = count << (2 * bits)
    share = total // SHARES + 1
    # One part for each thread: it takes its next share when it is done with one, as rays are not equally long and
    # cores not equally fast. Dealt out beforehand, they took 15 to 20 % longer.
    for _ in range(parts):
        begin = _next(turn, share, total)
        while begin < total:
            for ray in range(begin, ti.min(begin + share, total)):
                tile = tiles[ray >> (2 * bits)]
                tv, tu = tile >> 16, tile & 0xFFFF
                v = tv * TILE + ((ray >> bits) & (side - 1)) * step
                u = tu * TILE + (ray & (side - 1)) * step
                done = step != COARSE and (v | u) & (2 * step - 1) == 0
                if v >= height or u >= width or done:
                    continue
                end = last[tv, tu]
                z, difference, some, hit = 0.0, 0.0, True, -1.0
                if step != COARSE:
                    z, difference, some = _expected(depth, v, u, step)
                    if not some and 2.0 * step * end < SPACING * voxel * focal:
                        continue
                    if 2.0 * step * z > SPACING * voxel * focal or difference > 8.0 * voxel:
                        z = 0.0
                    if z > 0.0 and difference < 2.0 * voxel:
                        dv = ti.select(v & (2 * step - 1) == 0, 0, step)
                        du = ti.select(u & (2 * step - 1) == 0, 0, step)
                        hit = _between(depth, v, u, dv, du, SMOOTH * voxel)
                if hit < 0.0:
                    R = ti.Matrix([[pose[4 * a + b] for b in ti.static(range(3))] for a in ti.static(range(3))])
                    origin = ti.Vector([pose[3], pose[7], pose[11]]) / voxel
                    d = R @ ti.Vector([rays[v, u, 0], rays[v, u, 1], 1.0]) / voxel  # [voxels per metre of depth]
                    if z > 0.0:
                        hit = refine(origin, d, z, keys, ids, low, size, grid, neighbours, voxels, voxel)
                    if hit < 0.0:
                        hit = march(
                            origin, d, first[tv, tu], end, keys, ids, low, size, grid, solid, neighbours, voxels, voxel
                        )  # fmt: skip
                if hit > 0.0 and hit < end:
                    depth[v, u] = hit
            begin = _next(turn, share, total)
