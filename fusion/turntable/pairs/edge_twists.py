# mypy: ignore-errors
"""Pairs of views in any pose: what shape and print say about a small motion of one against the other, on Taichi."""

from fusion.compute.language import F32, F32_3, F64_2, func, kernel, ti
from fusion.compute.shares import SPLIT
from fusion.geometry.lanes import project
from fusion.turntable.pairs.edge_pairs import PairedViews

vec3 = ti.types.vector(3, ti.f32)
vec7 = ti.types.vector(7, ti.f32)
MATRIX = 35  # 28 of the lower triangle, 7 of the slope
COUNTS = 10
BLOCK = 64  # points
NOWHERE = -1e9  # [px]
WIDTH = 2 * MATRIX + COUNTS
VISIBLE, PAIRS, MISFIT, ODDS, FITTING, PRINTED = range(2 * MATRIX, 2 * MATRIX + 6)  # of print four sums more


@func
def _add(sums: ti.template(), e: ti.i32, at: ti.template(), d: ti.template(), weight: ti.f32, residual: ti.f32):
    k = 0
    for a in ti.static(range(7)):
        for b in ti.static(range(a + 1)):
            sums[e, at + k] = sums[e, at + k] + ti.cast(weight * d[a] * d[b], ti.f64)
            k += 1
    for a in ti.static(range(7)):
        sums[e, at + 28 + a] = sums[e, at + 28 + a] + ti.cast(weight * residual * d[a], ti.f64)


@func
def _count(sums: ti.template(), e: ti.i32, k: ti.i32, value: ti.f32):
    sums[e, k] = sums[e, k] + ti.cast(value, ti.f64)


@func
def _by_motion(R: ti.template(), p: ti.template(), met: ti.template(), arm: ti.template(), n: ti.template()):
    """By how much a place moves along n per unit of turn, shift and focal length."""
    turn, before = arm.cross(n), R.transpose() @ n
    zoom = n[0] * met[0] + n[1] * met[1] - before[0] * p[0] - before[1] * p[1]
    return vec7(turn[0], turn[1], turn[2], n[0], n[1], n[2], zoom)


@func
def _add_shape(
    sums: ti.template(), e: ti.i32, R: ti.template(), p: ti.template(), there: ti.template(), arm: ti.template(),
    n: ti.template(), residual: ti.f32, spread: ti.f32, limits: ti.template(),
):  # fmt: skip
    """What the distance of a pair says."""
    _count(sums, e, PAIRS, 1.0)
    _count(sums, e, MISFIT, ti.min((2.0 * residual / limits[0]) ** 2, 1.0))
    _count(sums, e, ODDS, ti.min(ti.abs(residual) / spread, 20.0))
    cut = 4.685 * limits[3] * spread if limits[3] > 0.0 else limits[0]
    inside = 1.0 - (residual / cut) ** 2
    if inside > 0.0 and limits[3] >= 0.0:
        _count(sums, e, FITTING, 1.0)
        d = _by_motion(R, p, there, arm, n)
        _add(sums, e, 0, d, (inside / (spread * ti.max(limits[3], 1.0))) ** 2, residual)


@func
def _add_print(
    sums: ti.template(), e: ti.i32, R: ti.template(), p: ti.template(), q: ti.template(), arm: ti.template(),
    x: ti.f32, y: ti.f32, j: ti.i32, images: ti.template(), own: ti.f32, lens: ti.template(), limits: ti.template(),
):  # fmt: skip
    """What its brightness says, at a place of image j."""
    a, b = ti.floor(x, ti.i32), ti.floor(y, ti.i32)
    if 0 <= a < images.shape[2] - 1 and 0 <= b < images.shape[1] - 1:
        fa, fb = x - a, y - b
        i00, i01 = images[j, b, a], images[j, b, a + 1]
        i10, i11 = images[j, b + 1, a], images[j, b + 1, a + 1]
        tone = (1 - fb) * ((1 - fa) * i00 + fa * i01) + fb * ((1 - fa) * i10 + fa * i11)
        off = tone - own
        if ti.abs(off) < 1e6:  # of NaN it is not true
            _count(sums, e, PRINTED, 1.0)
            _count(sums, e, PRINTED + 1, tone * own)
            _count(sums, e, PRINTED + 2, tone * tone)
            _count(sums, e, PRINTED + 3, own * own)
            _count(sums, e, PRINTED + 4, ti.abs(off))
            du = (1 - fb) * (i01 - i00) + fb * (i11 - i10)
            dv = (1 - fa) * (i10 - i00) + fa * (i11 - i01)
            gx = du * lens[0] / (limits[2] * q[2] * limits[6])
            gy = dv * lens[1] / (limits[2] * q[2] * limits[6])
            if limits[4] > 0.0 and limits[3] >= 0.0:
                d = _by_motion(R, p, q, arm, vec3(gx, gy, -(gx * q[0] + gy * q[1]) / q[2]))
                ratio = off / (2.4 * limits[4])
                _add(sums, e, MATRIX, d, 1.0 / (limits[4] * limits[4] * (1.0 + ratio * ratio)), off)


@func
def _find_places(
    right: ti.template(), down: ti.template(), R: ti.template(), t: ti.template(), begin: ti.i32, step: ti.i32,
    end: ti.i32, sources: ti.template(), maps: ti.template(), lens: ti.template(), limits: ti.template(),
):  # fmt: skip
    """Where in a map points lie, NOWHERE to the right outside; what is there is looked up in a loop of its own, see
    `edge_pairs`."""
    for k in range(end):
        at = begin + k * step
        q = R @ vec3(sources[at, 0] * limits[6], sources[at, 1] * limits[6], sources[at, 2]) + t
        x, y = project(q[0] / q[2] / limits[6], q[1] / q[2] / limits[6], lens, True)
        x, y = x / limits[2], y / limits[2]
        u, v = ti.floor(x + 0.5, ti.i32), ti.floor(y + 0.5, ti.i32)
        inside = (q[2] > 0.05) & (u >= 0) & (u < maps.shape[2]) & (v >= 0) & (v < maps.shape[1])
        right[k], down[k] = ti.select(inside, x, NOWHERE), y


@kernel
def twist_sums(
    views: PairedViews,
    tones: F32,  # (all,) brightness of the points, NaN where unknown
    images: F32_3,  # (n, h, w) that of the maps; (0, 0, 0) without colour
    lens: F32,  # (12,) the camera, see `geometry/lanes.py`
    centre: F32,  # (3,) about which the motion turns, in the model's frame
    limits: F32,  # (7,) reach [m], least cosine, stride of the maps, scale of sigma, tone (see `Limits`), most points,
    # stated over true focal length
    sums: F64_2,  # (m, WIDTH) zeros, out
):
    """Equations of each pair's motion, and counts."""
    edges, poses, first, maps = ti.static((views.edges, views.poses, views.first, views.maps))
    sources = ti.static(views.sources)
    for part in range(edges.shape[0] * SPLIT):
        if part % SPLIT == 0:
            e = part // SPLIT
            i, j = edges[e, 0], edges[e, 1]
            R = ti.Matrix([[poses[e, r, c] for c in ti.static(range(3))] for r in ti.static(range(3))])
            t = vec3(poses[e, 0, 3], poses[e, 1, 3], poses[e, 2, 3])
            middle = vec3(centre[0], centre[1], centre[2])
            step = ti.max(1, (first[i + 1] - first[i]) // ti.cast(limits[5], ti.i32))
            count = (first[i + 1] - first[i]) // step
            right, down, sigma = ti.Vector([0.0] * BLOCK), ti.Vector([0.0] * BLOCK), ti.Vector([0.0] * BLOCK)
            for block in range((count + BLOCK - 1) // BLOCK):
                begin, end = first[i] + block * BLOCK * step, ti.min(BLOCK, count - block * BLOCK)
                _find_places(right, down, R, t, begin, step, end, sources, maps, lens, limits)
                for k in range(end):
                    if right[k] > NOWHERE:
                        u, v = ti.floor(right[k] + 0.5, ti.i32), ti.floor(down[k] + 0.5, ti.i32)
                        sigma[k] = maps[j, v, u, 6]
                        if not maps[j, v, u, 2] > 0.0:
                            right[k] = NOWHERE
                for k in range(end):
                    if right[k] > NOWHERE:
                        at, x, y = begin + k * step, right[k], down[k]
                        u, v = ti.floor(x + 0.5, ti.i32), ti.floor(y + 0.5, ti.i32)
                        p = vec3(sources[at, 0] * limits[6], sources[at, 1] * limits[6], sources[at, 2])
                        q = R @ p + t
                        there = vec3(maps[j, v, u, 0] * limits[6], maps[j, v, u, 1] * limits[6], maps[j, v, u, 2])
                        n = vec3(maps[j, v, u, 3], maps[j, v, u, 4], maps[j, v, u, 5])
                        m = R @ vec3(sources[at, 3], sources[at, 4], sources[at, 5])
                        hidden = q[2] > there[2] + limits[0] or m.dot(q) > -0.3 * q.norm()
                        near = (q - there).norm() < limits[0] and m.dot(n) > limits[1]  # a NaN normal compares false
                        if near or not hidden:
                            _count(sums, e, VISIBLE, 1.0)
                        if near:
                            wide = ti.math.isnan(sigma[k])
                            spread = sources[at, 6] ** 2 + (0.0 if wide else sigma[k] ** 2)
                            spread = ti.max(ti.abs(n.dot(there)) / there.norm() * ti.sqrt(spread), 1e-5)
                            _add_shape(sums, e, R, p, there, q - middle, n, n.dot(q - there), spread, limits)
                            if images.shape[0] > 0:
                                _add_print(sums, e, R, p, q, q - middle, x, y, j, images, tones[at], lens, limits)
