# mypy: ignore-errors
"""Following a ray to the first place where the field goes from outside to inside."""

import taichi as ti

from fusion.volume.sample import blend, corners, slope, value
from fusion.volume.settings import BLOCK
from fusion.volume.window import find

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
def march(
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
def refine(
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
