# mypy: ignore-errors
"""Following rays to the first place where the field goes from outside to inside, many side by side: each on its own
would mostly wait for memory."""

from fusion.compute.language import ti
from fusion.geometry.lanes import high, low
from fusion.volume.blocks import entry
from fusion.volume.hashing import pack, slot
from fusion.volume.raycasting.window import find
from fusion.volume.sample import place
from fusion.volume.settings import BLOCK

SIDE = 16  # rays side by side
NEAR = 1.5  # voxels from the surface at which a coarse look is not enough
CLOSE = 0.02  # voxels from the surface at which a straight line finds it
LEAST = 1e-6  # of a depth that a step is long: less would be lost in rounding

# Of each ray: its direction [voxels per metre of depth], the depths where it is, begins and ends, the last value
# outside and the first one inside (negative and positive: none) with their depths, that of the surface, and that where
# it leaves the block [m].
DX, DY, DZ, AT, START, END, OUT, AT_OUT, IN, AT_IN, HIT, LEAVE = [SIDE * n for n in range(12)]
# And its state, looks left to come from a guess to the surface, pixel, the block where it is, voxel.
STATE, TRIALS, PIXEL, CELL, VOXEL = [SIDE * n for n in range(5)]
NUMBERS, WHOLES = 12 * SIDE, 5 * SIDE
FAR, NEARBY, DONE = 0, 1, 2  # states


@ti.func
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


@ti.func
def _axis(p: ti.f32, d: ti.f32, o: ti.f32):
    """Voxel on an axis at a place, and the depth at which a ray leaves its block there."""
    i = ti.cast(ti.floor(p), ti.i32)
    side = ti.cast(i & ~(BLOCK - 1), ti.f32) + ti.select(d > 0.0, float(BLOCK), 0.0)
    return i, ti.select(ti.abs(d) > 1e-9, (side - o) / d, 1e30)


@ti.func
def approach(
    ray: ti.template(), whole: ti.template(), origin: ti.template(), keys: ti.template(), ids: ti.template(),
    lowest: ti.template(), size: ti.template(), grid: ti.template(), solid: ti.template(), voxels: ti.template(),
    voxel: ti.f32,
):  # fmt: skip
    """A step of each ray that is far from the surface, by what the nearest voxel says."""
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
            block[e] = ti.select(n >= 0, grid[ti.max(n, 0)], -1)
    else:
        e, h, key = 0, -1, ti.cast(-1, ti.i64)
        while e < SIDE:  # as `lookup` for each; with a loop inside of this one the compiler would write it eight times
            if h < 0:
                d = ti.Vector([ray[DX + e], ray[DY + e], ray[DZ + e]])
                p = ti.cast(ti.floor(origin + 0.5 + d * ray[AT + e]), ti.i32) >> 3
                key, h = pack(p[0], p[1], p[2]), slot(p[0], p[1], p[2], keys.shape[0])
            seen = keys[h]
            if seen == key or seen == -1:
                block[e] = ti.select(seen == key, ids[h], -1)
                e, h = e + 1, -1
            else:
                h = (h + 1) & (keys.shape[0] - 1)
    for e in range(SIDE):
        n = ti.max(block[e], 0)
        i = entry(n, whole[VOXEL + e])
        full[e], value[e], weight[e] = solid[n], voxels[i], voxels[i + BLOCK]
    for e in range(SIDE):
        dx, dy, dz, t, w = ray[DX + e], ray[DY + e], ray[DZ + e], ray[AT + e], weight[e]
        quantum = 1.0 / ti.sqrt(dx * dx + dy * dy + dz * dz)  # depth of one voxel's length [m]
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


@ti.func
def close(
    ray: ti.template(), whole: ti.template(), origin: ti.template(), keys: ti.template(), ids: ti.template(),
    lowest: ti.template(), size: ti.template(), grid: ti.template(), neighbours: ti.template(), voxels: ti.template(),
    voxel: ti.f32,
):  # fmt: skip
    """A step of each ray that was near the surface: Newton's where the field falls, kept between the last place outside
    and the first one inside once both are known."""
    value, weight = ti.Vector([0.0] * (8 * SIDE)), ti.Vector([0.0] * (8 * SIDE))
    part = ti.Vector([0.0] * (3 * SIDE))  # where in its cell a ray is
    for e in range(SIDE):  # what the corners of its cell say
        if whole[STATE + e] == NEARBY:
            p = origin + ti.Vector([ray[DX + e], ray[DY + e], ray[DZ + e]]) * ray[AT + e]
            base = ti.cast(ti.floor(p), ti.i32)
            n = find(base >> 3, lowest, size, grid, keys, ids)
            for a in ti.static(range(3)):
                part[a * SIDE + e] = p[a] - base[a]
            if n >= 0:
                i, j, k = base[0] & 7, base[1] & 7, base[2] & 7
                if ti.max(i, j, k) < BLOCK - 1:  # all in one block
                    at = entry(n, (i * BLOCK + j) * BLOCK + k)
                    for c in ti.static(range(8)):
                        corner = at + ti.static(c // 4 * 128 + c // 2 % 2 * 16 + c % 2)
                        value[c * SIDE + e], weight[c * SIDE + e] = voxels[corner], voxels[corner + BLOCK]
                else:
                    for c in range(8):
                        block, o = place(n, i + c // 4, j + c // 2 % 2, k + c % 2, neighbours)
                        if block >= 0:
                            corner = entry(block, o)
                            value[c * SIDE + e], weight[c * SIDE + e] = voxels[corner], voxels[corner + BLOCK]
    for e in range(SIDE):
        x, y, z = part[e], part[SIDE + e], part[2 * SIDE + e]
        dx, dy, dz, t = ray[DX + e], ray[DY + e], ray[DZ + e], ray[AT + e]
        least = weight[e]
        for c in ti.static(range(1, 8)):
            least = low(least, weight[c * SIDE + e])
        v = ti.Vector([value[c * SIDE + e] / weight[c * SIDE + e] for c in ti.static(range(8))])
        along = [v[c + 4] - v[c] for c in ti.static(range(4))]
        a = [v[c] + along[c] * x for c in ti.static(range(4))]
        b, up = [a[c] + (a[c + 2] - a[c]) * y for c in ti.static(range(2))], a[3] - a[1] - (a[2] - a[0])
        slope_x = along[0] + (along[2] - along[0]) * y
        slope_x += (along[1] + (along[3] - along[1]) * y - slope_x) * z
        known = least > 0.0
        s = ti.select(known, b[0] + (b[1] - b[0]) * z, 0.0)
        rate = ti.select(known, slope_x * dx + (a[2] - a[0] + up * z) * dy + (b[1] - b[0]) * dz, 1.0)
        quantum = 1.0 / ti.sqrt(dx * dx + dy * dy + dz * dz)
        out, at_out, inside, at_in = ray[OUT + e], ray[AT_OUT + e], ray[IN + e], ray[AT_IN + e]
        trials, to = whole[TRIALS + e], t - s / rate
        blunt = (least <= 0.0) | (rate >= -0.1 * voxel / quantum)  # unknown, or seen at more than 84 degrees
        at_surface = (ti.abs(s) < CLOSE * voxel) | (ti.abs(s / rate) < LEAST * t)
        found = (rate < -0.1 * voxel / quantum) & known & at_surface & ((trials > 0) | (out > 0.0))
        # from a guess: the next look, or back to the start
        guessed = trials > 0
        lost = blunt | (ti.abs(s) > voxel) | (trials == 1)
        # inside from the start, or the back of a surface
        astray = (least <= 0.0) | ((s <= 0.0) & (out < 0.0))
        # between places
        outside = s > 0.0
        out1, at_out1 = ti.select(outside, s, out), ti.select(outside, t, at_out)
        in1, at_in1 = ti.select(outside, inside, s), ti.select(outside, at_in, t)
        both, gap, share = in1 <= 0.0, at_in1 - at_out1, out1 / (out1 - in1)
        step = (s / voxel + 0.3) * quantum
        cut = ti.select(blunt | (to <= at_out1) | (to >= at_out1 + gap), at_out1 + gap * share, to)
        # never nearer to an end: from cell to cell the slope jumps, and two places may send to each other
        cut = low(high(cut, at_out1 + 0.05 * gap), at_out1 + 0.95 * gap)
        narrow = both & (gap < 0.05 * quantum + LEAST * t)
        ahead = ti.select(blunt | (to > t + 2.0 * step), t + step, to)
        next_at = ti.select(both, cut, ahead)
        next_state = ti.select(narrow, DONE, ti.select((s > NEAR * voxel) & (in1 > 0.0), FAR, NEARBY))
        # which of the four it is
        live = whole[STATE + e] == NEARBY
        other = ti.select(found | guessed, 0, ti.cast(live, ti.i32))
        bracket, stray = ti.select(astray, 0, other) == 1, ti.select(astray, other, 0) == 1
        next_at = ti.select(astray, t + ti.select(known, 1.0, 0.5) * quantum, next_at)
        next_state = ti.select(astray, FAR, next_state)
        next_at = ti.select(guessed, ti.select(lost, ray[START + e], to), next_at)
        next_state = ti.select(guessed, ti.select(lost, FAR, NEARBY), next_state)
        next_at = ti.select(found, t, next_at)
        next_state = ti.select(found, DONE, ti.select(next_at < ray[END + e], next_state, DONE))  # or NaN
        ray[HIT + e] = ti.select(live & found, to, ti.select(bracket & narrow, at_out1 + gap * share, ray[HIT + e]))
        ray[AT + e] = ti.select(live, next_at, t)
        ray[OUT + e] = ti.select(bracket, out1, ti.select(stray & (least <= 0.0), -1.0, out))
        ray[AT_OUT + e] = ti.select(bracket, at_out1, at_out)
        ray[IN + e] = ti.select(bracket, in1, ti.select(stray, 1.0, inside))
        ray[AT_IN + e] = ti.select(bracket, at_in1, at_in)
        whole[TRIALS + e] = ti.select(live & guessed, ti.select(lost, 0, trials - 1), trials)
        whole[STATE + e] = ti.select(live, next_state, whole[STATE + e])
