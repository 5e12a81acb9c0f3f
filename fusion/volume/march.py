# mypy: ignore-errors
"""Following rays to the first place where the field goes from outside to inside."""

import taichi as ti

from fusion.volume.blocks import F32, F32_2, F32_3, I32, I32_2, I64
from fusion.volume.sample import blend, corners, slope, value
from fusion.volume.settings import BLOCK
from fusion.volume.window import TILE, find

COARSE = 4  # pixels between the rays that are followed first; those between them mostly meet the same surface
SMOOTH = 0.05  # voxels that a bend may move the surface between two rays; then their curve says where it is
SPACING = 3.0  # voxels between rays that are done: what fits between them is too narrow for voxels to hold
CLOSE = 0.02  # voxels from the surface at which a straight line finds it


@ti.func
def _field(p: ti.template(), n: ti.i32, neighbours: ti.template(), voxels: ti.template()):
    """Trilinear distance [m] at p [voxels], in block n, and the lowest weight around; weight 0 where never seen."""
    base = ti.cast(ti.floor(p), ti.i32)
    distance = 0.0
    weight = 0.0
    if n >= 0:
        f, lowest = corners(n, base[0] & 7, base[1] & 7, base[2] & 7, neighbours, voxels)
        distance = blend(f, p - base)
        weight = lowest
    return distance, weight


@ti.func
def _march(
    origin: ti.template(), d: ti.template(), start: ti.f32, last: ti.f32, keys: ti.template(), ids: ti.template(),
    low: ti.template(), size: ti.template(), grid: ti.template(), solid: ti.template(), neighbours: ti.template(),
    voxels: ti.template(), voxel: ti.f32,
):  # fmt: skip
    """Depth at which the ray origin + d * depth [voxels] meets the surface between two depths; -1 for none."""
    t = start
    ahead = ti.Vector([BLOCK if d[a] > 0.0 else 0.0 for a in ti.static(range(3))])  # the side that a ray leaves by
    inverse_d = ti.Vector([1.0 / d[a] if ti.abs(d[a]) > 1e-9 else ti.math.nan for a in ti.static(range(3))])
    quantum = 1.0 / d.norm()  # depth of one voxel's length [m]
    before, t_before = -1.0, t  # the last value known to be outside; negative = none
    n, at = -1, ti.Vector([1 << 30, 0, 0])  # the block looked up last
    hollow = False
    hit = -1.0
    while t < last and hit < 0.0:
        p = origin + d * t
        base = ti.cast(ti.floor(p), ti.i32)
        block = base >> 3
        if block[0] != at[0] or block[1] != at[1] or block[2] != at[2]:
            at = block
            n = find(block, low, size, grid, keys, ids)
            hollow = n >= 0 and solid[n] == 0
        leave = t
        if n < 0 or hollow:
            leave = ((ti.cast(block * BLOCK, ti.f32) + ahead - origin) * inverse_d).min()
            if hollow:  # there it only has to be seen from which side the ray comes
                leave -= 1.5 * quantum
        if n < 0 or leave > t:  # on to where the ray leaves this block
            t = ti.max(t, leave) + 0.01 * quantum
            before = -1.0
        else:
            nearest = ti.cast(ti.floor(p + 0.5), ti.i32) - block * BLOCK
            s, w = value(n, nearest[0], nearest[1], nearest[2], neighbours, voxels)
            if w <= 0.0:  # never seen
                before = -1.0
                t += quantum
            elif before < 0.0 and s < -1.8 * voxel:  # well inside, and not come from outside
                t += quantum
            elif s > 1.5 * voxel:  # well outside: a coarse look is enough, and the next one may be just behind
                before = s
                t_before = t
                t += ti.max(0.8 * s / voxel, s / voxel - 0.5) * quantum
            else:
                local = base & 7
                f, lowest = corners(n, local[0], local[1], local[2], neighbours, voxels)
                s = blend(f, p - base)
                if lowest <= 0.0:
                    before = -1.0
                    t += 0.5 * quantum
                elif s > 0.0:
                    before = s
                    t_before = t
                    t += (s / voxel + 0.3) * quantum
                elif before < 0.0:  # inside from the start, or the back of a surface
                    t += quantum
                else:
                    t0, f0, t1, f1 = t_before, before, t, s
                    known = True
                    for _ in range(4):  # the false position converges fast on a nearly linear field
                        if known and ti.min(f0, -f1) > CLOSE * voxel:
                            m = t0 + (t1 - t0) * ti.min(ti.max(f0 / (f0 - f1), 0.02), 0.98)
                            pm = origin + d * m
                            nm = find(ti.cast(ti.floor(pm), ti.i32) >> 3, low, size, grid, keys, ids)
                            fm, wm = _field(pm, nm, neighbours, voxels)
                            known = wm > 0.0
                            if fm > 0.0:
                                t0, f0 = m, fm
                            else:
                                t1, f1 = m, fm
                    if known:
                        hit = t0 + (t1 - t0) * f0 / (f0 - f1)
                    else:
                        before = -1.0
                        t += quantum
    return hit


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
def _refine(
    origin: ti.template(), d: ti.template(), guess: ti.f32, keys: ti.template(), ids: ti.template(),
    low: ti.template(), size: ti.template(), grid: ti.template(), neighbours: ti.template(), voxels: ti.template(),
    voxel: ti.f32,
):  # fmt: skip
    """Newton's method from a depth within a voxel of the surface; -1 where that is not so."""
    t, hit, rate, off = guess, -1.0, -1.0, voxel
    for _ in range(3):
        if rate < 0.0 and ti.abs(off) > CLOSE * voxel:
            p = origin + d * t
            base = ti.cast(ti.floor(p), ti.i32)
            n = find(base >> 3, low, size, grid, keys, ids)
            rate = 1.0
            if n >= 0:
                f, lowest = corners(n, base[0] & 7, base[1] & 7, base[2] & 7, neighbours, voxels)
                off = blend(f, p - base)
                if lowest > 0.0 and ti.abs(off) < voxel:
                    rate = slope(f, p - base).dot(d)
                    # seen at more than 84 degrees, the next step would lead anywhere
                    if rate < -0.1 * voxel * d.norm():
                        t -= off / rate
                    else:
                        rate = 1.0
    if rate < 0.0 and ti.abs(off) < 0.1 * voxel:
        hit = t
    return hit


@ti.kernel
def cast(
    step: ti.i32, keys: I64, ids: I32, low: I32, size: I32, grid: I32, solid: I32, neighbours: I32_2, voxels: F32,
    rays: F32_3, pose: F32, first: F32_2, last: F32_2, tiles: I32, count: ti.i32, voxel: ti.f32, focal: ti.f32,
    depth: F32_2,
):  # fmt: skip
    """Fills in the depths (NaN before) of every step-th pixel in both directions; those at twice the step are taken as
    done, unless the step is COARSE. What such rays enclose is less than SPACING wide, or else every ray is followed
    from its start; where they all met nothing, neither do those between them."""
    height, width = depth.shape[0], depth.shape[1]
    side = TILE // step
    bits = ti.select(side == TILE, 3, ti.select(side == 4, 2, 1))  # divisions would take as long as the rest
    for ray in range(count << (2 * bits)):  # one by one: the CPU pool never splits below 512 iterations
        tile = tiles[ray >> (2 * bits)]
        tv, tu = tile >> 16, tile & 0xFFFF
        v = tv * TILE + ((ray >> bits) & (side - 1)) * step
        u = tu * TILE + (ray & (side - 1)) * step
        done = step != COARSE and (v | u) & (2 * step - 1) == 0
        if v < height and u < width and not done:
            end = last[tv, tu]
            z, difference, some, hit = 0.0, 0.0, True, -1.0
            if step != COARSE:
                z, difference, some = _expected(depth, v, u, step)
                if not some and 2.0 * step * end < SPACING * voxel * focal:
                    continue
                if 2.0 * step * z > SPACING * voxel * focal or difference > 8.0 * voxel:
                    z = 0.0
                if z > 0.0 and difference < 2.0 * voxel:
                    dv, du = ti.select(v & (2 * step - 1) == 0, 0, step), ti.select(u & (2 * step - 1) == 0, 0, step)
                    hit = _between(depth, v, u, dv, du, SMOOTH * voxel)
            if hit < 0.0:
                R = ti.Matrix([[pose[0], pose[1], pose[2]], [pose[4], pose[5], pose[6]], [pose[8], pose[9], pose[10]]])
                origin = ti.Vector([pose[3], pose[7], pose[11]]) / voxel
                d = R @ ti.Vector([rays[v, u, 0], rays[v, u, 1], 1.0]) / voxel  # [voxels per metre of depth]
                if z > 0.0:
                    hit = _refine(origin, d, z, keys, ids, low, size, grid, neighbours, voxels, voxel)
                if hit < 0.0:
                    hit = _march(
                        origin, d, first[tv, tu], end, keys, ids, low, size, grid, solid, neighbours, voxels, voxel
                    )  # fmt: skip
            if hit > 0.0 and hit < end:
                depth[v, u] = hit
