# mypy: ignore-errors
"""From near the surface to the place where the field goes from outside to inside, for all rays that are there."""

from fusion.compute.language import func, ti
from fusion.geometry.lanes import high, low
from fusion.volume.blocks import entry
from fusion.volume.raycasting.march import (
    AT,
    AT_IN,
    AT_OUT,
    DONE,
    DX,
    DY,
    DZ,
    END,
    FAR,
    HIT,
    IN,
    LEAST,
    NEAR,
    NEARBY,
    OUT,
    SIDE,
    START,
    STATE,
    TRIALS,
    quantum_of,
)
from fusion.volume.raycasting.window import find
from fusion.volume.sample import blend, place, slope
from fusion.volume.settings import BLOCK

CLOSE = 0.02  # voxels from the surface at which a straight line finds it
GRAZING = 0.1  # cosine of the largest angle, 84 degrees, at which the field's slope says where it is
CORNERS = 8 * SIDE  # of all rays' cells; corner c of ray e is at c * SIDE + e


@func
def _read(
    ray: ti.template(), whole: ti.template(), part: ti.template(), value: ti.template(), weight: ti.template(),
    origin: ti.template(), field: ti.template(),
):  # fmt: skip
    """What the corners of each ray's cell say, and where in it the ray is, as three parts of its edges."""
    voxels = ti.static(field.voxels)
    for e in range(SIDE):
        if whole[STATE + e] == NEARBY:
            p = origin + ti.Vector([ray[DX + e], ray[DY + e], ray[DZ + e]]) * ray[AT + e]
            base = ti.cast(ti.floor(p), ti.i32)
            n = find(base >> 3, field)
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
                        block, o = place(n, i + c // 4, j + c // 2 % 2, k + c % 2, field.neighbours)
                        if block >= 0:
                            corner = entry(block, o)
                            value[c * SIDE + e], weight[c * SIDE + e] = voxels[corner], voxels[corner + BLOCK]


@func
def _field(ray: ti.template(), part: ti.template(), value: ti.template(), weight: ti.template(), e: ti.i32):
    """Whether all corners of ray e's cell are known, the trilinear value there and its rate along the ray [m/m]; 0 and
    1 where not."""
    least = weight[e]
    for c in ti.static(range(1, 8)):
        least = low(least, weight[c * SIDE + e])
    f = ti.Vector([value[c * SIDE + e] / weight[c * SIDE + e] for c in ti.static(range(8))])
    p = ti.Vector([part[a * SIDE + e] for a in ti.static(range(3))])
    rate = slope(f, p).dot(ti.Vector([ray[DX + e], ray[DY + e], ray[DZ + e]]))
    known = least > 0.0
    return known, ti.select(known, blend(f, p), 0.0), ti.select(known, rate, 1.0)


@func
def close(ray: ti.template(), whole: ti.template(), origin: ti.template(), field: ti.template()):
    """A step of each ray that was near the surface: Newton's where the field falls, kept between the last place outside
    and the first one inside once both are known."""
    value, weight = ti.Vector([0.0] * CORNERS), ti.Vector([0.0] * CORNERS)
    part = ti.Vector([0.0] * (3 * SIDE))
    voxel = field.voxel
    _read(ray, whole, part, value, weight, origin, field)
    for e in range(SIDE):  # without branches, so that the compiler makes vectors of it: all ways on, then which it is
        known, s, rate = _field(ray, part, value, weight, e)
        t, trials, quantum = ray[AT + e], whole[TRIALS + e], quantum_of(ray, e)
        falls = known & (rate < -GRAZING * voxel / quantum)
        to = t - s / rate
        # at the surface
        at_surface = (ti.abs(s) < CLOSE * voxel) | (ti.abs(s / rate) < LEAST * t)
        found = falls & at_surface & ((trials > 0) | (ray[OUT + e] > 0.0))
        # from a guess the next look, or back to the start
        lost = ~falls | (ti.abs(s) > voxel) | (trials == 1)
        guess_at, guess_state = ti.select(lost, ray[START + e], to), ti.select(lost, FAR, NEARBY)
        # inside from the start, the back of a surface, or nothing known: through it
        astray = ~known | ((s <= 0.0) & (ray[OUT + e] < 0.0))
        stray_at = t + ti.select(known, 1.0, 0.5) * quantum
        # between the last place outside and the first one inside, or on to the latter
        outside = s > 0.0
        out, at_out = ti.select(outside, s, ray[OUT + e]), ti.select(outside, t, ray[AT_OUT + e])
        inside, at_in = ti.select(outside, ray[IN + e], s), ti.select(outside, ray[AT_IN + e], t)
        both, gap = inside <= 0.0, at_in - at_out
        straight = at_out + gap * (out / (out - inside))
        between = ti.select(~falls | (to <= at_out) | (to >= at_out + gap), straight, to)
        # never nearer to an end: from cell to cell the slope jumps, and two places may send to each other
        between = low(high(between, at_out + 0.05 * gap), at_out + 0.95 * gap)
        narrow = both & (gap < 0.05 * quantum + LEAST * t)
        step = (s / voxel + 0.3) * quantum
        ahead = ti.select(~falls | (to > t + 2.0 * step), t + step, to)
        # with a place inside, one that goes far again would walk past it, and come back
        path_at = ti.select(both, between, ahead)
        path_state = ti.select(narrow, DONE, ti.select((s > NEAR * voxel) & ~both, FAR, NEARBY))

        live, guessed = whole[STATE + e] == NEARBY, trials > 0
        stray, path = live & ~found & ~guessed & astray, live & ~found & ~guessed & ~astray
        next_at = ti.select(guessed, guess_at, ti.select(astray, stray_at, path_at))
        next_state = ti.select(guessed, guess_state, ti.select(astray, FAR, path_state))
        ended = found | ~(next_at < ray[END + e])  # or NaN
        ray[HIT + e] = ti.select(live & found, to, ti.select(path & narrow, straight, ray[HIT + e]))
        ray[AT + e] = ti.select(live, next_at, t)
        ray[OUT + e] = ti.select(path, out, ti.select(stray & ~known, -1.0, ray[OUT + e]))
        ray[AT_OUT + e] = ti.select(path, at_out, ray[AT_OUT + e])
        ray[IN + e] = ti.select(path, inside, ti.select(stray, 1.0, ray[IN + e]))
        ray[AT_IN + e] = ti.select(path, at_in, ray[AT_IN + e])
        whole[TRIALS + e] = ti.select(live & guessed, ti.select(lost, 0, trials - 1), trials)
        whole[STATE + e] = ti.select(live, ti.select(ended, DONE, next_state), whole[STATE + e])
