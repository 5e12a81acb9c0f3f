# mypy: ignore-errors
"""Following rays, many side by side, as each on its own would mostly wait for memory: what is known of each of them,
and the way to near the surface; `close` goes on from there."""

from fusion.compute.language import func, ti
from fusion.geometry.lanes import high, low
from fusion.volume.blocks import entry
from fusion.volume.hashing import pack, slot
from fusion.volume.settings import BLOCK

SIDE = 16  # rays side by side
NEAR = 1.5  # voxels from the surface at which a coarse look is not enough
LEAST = 1e-6  # of a depth that a step is long: less would be lost in rounding

# Of each ray: its direction [voxels per metre of depth], the depths where it is, begins and ends, the last value
# outside and the first one inside (negative and positive: none) with their depths, that of the surface, and that where
# it leaves the block [m].
DX, DY, DZ, AT, START, END, OUT, AT_OUT, IN, AT_IN, HIT, LEAVE = [SIDE * n for n in range(12)]
# And its state, looks left to come from a guess to the surface, pixel, the block where it is, voxel.
STATE, TRIALS, PIXEL, CELL, VOXEL = [SIDE * n for n in range(5)]
NUMBERS, WHOLES = 12 * SIDE, 5 * SIDE
FAR, NEARBY, DONE = 0, 1, 2  # states


@func
def begin(
    ray: ti.template(), whole: ti.template(), e: ti.i32, d: ti.template(), pixel: ti.i32, near: ti.f32, far: ti.f32,
    guess: ti.f32,
):  # fmt: skip
    """Sets ray e on its way between two depths, or from a guess above 0 that lies within a voxel of the surface."""
    ray[DX + e], ray[DY + e], ray[DZ + e] = d[0], d[1], d[2]
    ray[START + e], ray[END + e] = near, far
    ray[OUT + e], ray[IN + e], ray[HIT + e] = -1.0, 1.0, -1.0
    guessed = guess > 0.0
    ray[AT + e] = ti.select(guessed, guess, near)
    whole[PIXEL + e], whole[TRIALS + e] = pixel, ti.select(guessed, 3, 0)
    whole[STATE + e] = ti.select(guessed, NEARBY, FAR)


@func
def quantum_of(ray: ti.template(), e: ti.i32):
    """Depth of one voxel's length along ray e [m]."""
    dx, dy, dz = ray[DX + e], ray[DY + e], ray[DZ + e]
    return 1.0 / ti.sqrt(dx * dx + dy * dy + dz * dz)


@func
def _axis(p: ti.f32, d: ti.f32, o: ti.f32):
    """Voxel on an axis at a place, and the depth at which a ray leaves its block there."""
    i = ti.cast(ti.floor(p), ti.i32)
    side = ti.cast(i & ~(BLOCK - 1), ti.f32) + ti.select(d > 0.0, float(BLOCK), 0.0)
    return i, ti.select(ti.abs(d) > 1e-9, (side - o) / d, 1e30)


@func
def approach(ray: ti.template(), whole: ti.template(), origin: ti.template(), field: ti.template()):
    """A step of each ray that is far from the surface, by what the nearest voxel says."""
    keys, lowest, size, voxel = ti.static((field.keys, field.low, field.size, field.voxel))
    value, weight = ti.Vector([0.0] * SIDE), ti.Vector([0.0] * SIDE)
    block, full = ti.Vector([0] * SIDE), ti.Vector([0] * SIDE)
    ox, oy, oz = origin[0] + 0.5, origin[1] + 0.5, origin[2] + 0.5
    x0, y0, z0, nx, ny, nz = lowest[0], lowest[1], lowest[2], size[0], size[1], size[2]
    for e in range(SIDE):
        dx, dy, dz, t = ray[DX + e], ray[DY + e], ray[DZ + e], ray[AT + e]
        i, leave_x = _axis(ox + dx * t, dx, ox)
        j, leave_y = _axis(oy + dy * t, dy, oy)
        k, leave_z = _axis(oz + dz * t, dz, oz)
        ray[LEAVE + e] = low(low(leave_x, leave_y), leave_z)
        whole[VOXEL + e] = ((i & 7) * BLOCK + (j & 7)) * BLOCK + (k & 7)
        i, j, k = (i >> 3) - x0, (j >> 3) - y0, (k >> 3) - z0
        within = (i >= 0) & (j >= 0) & (k >= 0) & (i < nx) & (j < ny) & (k < nz)
        whole[CELL + e] = ti.select(within, (i * ny + j) * nz + k, -1)
    if nx > 0:
        for e in range(SIDE):
            n = whole[CELL + e]
            block[e] = ti.select(n >= 0, field.grid[ti.max(n, 0)], -1)
    else:
        e, h, key = 0, -1, ti.cast(-1, ti.i64)
        while e < SIDE:  # as `lookup` for each; with a loop inside of this one the compiler would write it eight times
            if h < 0:
                d = ti.Vector([ray[DX + e], ray[DY + e], ray[DZ + e]])
                p = ti.cast(ti.floor(origin + 0.5 + d * ray[AT + e]), ti.i32) >> 3
                key, h = pack(p[0], p[1], p[2]), slot(p[0], p[1], p[2], keys.shape[0])
            seen = keys[h]
            if seen == key or seen == -1:
                block[e] = ti.select(seen == key, field.ids[h], -1)
                e, h = e + 1, -1
            else:
                h = (h + 1) & (keys.shape[0] - 1)
    for e in range(SIDE):
        n = ti.max(block[e], 0)
        i = entry(n, whole[VOXEL + e])
        full[e], value[e], weight[e] = field.solid[n], field.voxels[i], field.voxels[i + BLOCK]
    for e in range(SIDE):
        t, w = ray[AT + e], weight[e]
        quantum = quantum_of(ray, e)
        distance = value[e] / (w * voxel)
        empty = block[e] < 0
        # there it only has to be seen from which side the ray comes
        hollow = (full[e] == 0) & (ray[LEAVE + e] - NEAR * quantum > t)
        skip, unseen = empty | hollow, w <= 0.0
        back = (ray[OUT + e] < 0.0) & (distance < -1.8)  # well inside, and not come from outside
        ahead = ti.select(unseen | back, 1.0, high(0.8 * distance, distance - 0.5)) * quantum
        on = high(t, ray[LEAVE + e] - ti.select(empty, 0.0, NEAR * quantum)) + 0.01 * quantum + LEAST * t
        live, look_closer = whole[STATE + e] == FAR, ~(skip | unseen | back) & (distance <= NEAR)
        outside = live & ~(skip | unseen | back | look_closer)
        ray[AT_OUT + e] = ti.select(outside, t, ray[AT_OUT + e])
        before = ti.select(live & (skip | unseen), -1.0, ray[OUT + e])
        ray[OUT + e] = ti.select(outside, distance * voxel, before)
        to = ti.select(live & ~look_closer, ti.select(skip, on, t + ahead), t)
        ray[AT + e] = to
        now = ti.select(to < ray[END + e], ti.select(look_closer, NEARBY, FAR), DONE)  # of NaN, too
        whole[STATE + e] = ti.select(live, now, whole[STATE + e])
