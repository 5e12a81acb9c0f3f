# mypy: ignore-errors
"""Pairs of views in any pose: what shape and print say about a small motion of one against the other, on Taichi."""

from fusion.compute.arrays import F32, F32_2, F64_2, I32, I32_2
from fusion.compute.language import func, kernel, ti
from fusion.compute.shares import SPLIT
from fusion.geometry.lanes import project

vec3 = ti.types.vector(3, ti.f32)
vec7 = ti.types.vector(7, ti.f32)
MATRIX = 35  # 28 of the lower triangle, 7 of the slope
COUNTS = 10
WIDTH = 2 * MATRIX + COUNTS


@func
def _add(sums: ti.template(), e: ti.i32, at: ti.template(), d: ti.template(), weight: ti.f32, residual: ti.f32):
    k = 0
    for a in ti.static(range(7)):
        for b in ti.static(range(a + 1)):
            sums[e, at + k] = sums[e, at + k] + ti.cast(weight * d[a] * d[b], ti.f64)
            k += 1
    for a in ti.static(range(7)):
        sums[e, at + 28 + a] = sums[e, at + 28 + a] + ti.cast(weight * residual * d[a], ti.f64)


@kernel
def twist_sums(
    edges: I32_2,  # (m, 2) source and model view
    poses: ti.types.ndarray(dtype=ti.f32, ndim=3),  # (m, 4, 4) model from source
    first: I32,  # (n + 1,) where the points of each view start
    sources: F32_2,  # (all, 7) point, normal, sigma
    tones: F32,  # (all,) brightness of the points, NaN where unknown
    maps: ti.types.ndarray(dtype=ti.f32, ndim=4),  # (n, h, w, 7) the same of every view's pixels
    images: ti.types.ndarray(dtype=ti.f32, ndim=3),  # (n, h, w) their brightness; (0, 0, 0) without colour
    lens: F32,  # (12,) the camera, see `association`
    centre: F32,  # (3,) about which the motion turns, in the model's frame
    limits: F32,  # (7,) reach [m], least cosine, stride of the maps, scale of sigma, tone (see `Limits`), most points,
    # stated over true focal length
    sums: F64_2,  # (m, WIDTH) zeros, out
):
    for part in range(edges.shape[0] * SPLIT):
        if part % SPLIT == 0:
            e = part // SPLIT
            i, j = edges[e, 0], edges[e, 1]
            R = ti.Matrix([[poses[e, r, c] for c in ti.static(range(3))] for r in ti.static(range(3))])
            t = vec3(poses[e, 0, 3], poses[e, 1, 3], poses[e, 2, 3])
            middle = vec3(centre[0], centre[1], centre[2])
            height, width = maps.shape[1], maps.shape[2]
            reach, stride = limits[0], limits[2]
            count = first[i + 1] - first[i]
            step = ti.max(1, count // ti.cast(limits[5], ti.i32))
            for number in range(count // step):
                at = first[i] + number * step
                p = vec3(sources[at, 0] * limits[6], sources[at, 1] * limits[6], sources[at, 2])
                q = R @ p + t
                x, y = project(q[0] / q[2] / limits[6], q[1] / q[2] / limits[6], lens, True)
                x, y = x / stride, y / stride
                u, v = ti.floor(x + 0.5, ti.i32), ti.floor(y + 0.5, ti.i32)
                if q[2] > 0.05 and 0 <= u < width and 0 <= v < height and maps[j, v, u, 2] > 0.0:
                    there = vec3(maps[j, v, u, 0] * limits[6], maps[j, v, u, 1] * limits[6], maps[j, v, u, 2])
                    n = vec3(maps[j, v, u, 3], maps[j, v, u, 4], maps[j, v, u, 5])
                    m = R @ vec3(sources[at, 3], sources[at, 4], sources[at, 5])
                    apart = (q - there).norm()
                    hidden = q[2] > there[2] + reach or m.dot(q) > -0.3 * q.norm()
                    near = apart < reach and m.dot(n) > limits[1]  # a NaN normal compares false
                    if near or not hidden:
                        sums[e, 2 * MATRIX] = sums[e, 2 * MATRIX] + 1.0  # visible
                    if near:
                        residual = n.dot(q - there)
                        wide = ti.math.isnan(maps[j, v, u, 6])
                        spread = sources[at, 6] ** 2 + (0.0 if wide else maps[j, v, u, 6] ** 2)
                        spread = ti.max(ti.abs(n.dot(there)) / there.norm() * ti.sqrt(spread), 1e-5)
                        sums[e, 2 * MATRIX + 1] = sums[e, 2 * MATRIX + 1] + 1.0  # pairs
                        far = ti.min((2.0 * residual / reach) ** 2, 1.0)
                        sums[e, 2 * MATRIX + 2] = sums[e, 2 * MATRIX + 2] + ti.cast(far, ti.f64)
                        odds = ti.abs(residual) / spread
                        sums[e, 2 * MATRIX + 3] = sums[e, 2 * MATRIX + 3] + ti.cast(ti.min(odds, 20.0), ti.f64)
                        cut = 4.685 * limits[3] * spread if limits[3] > 0.0 else reach
                        inside = 1.0 - (residual / cut) ** 2
                        arm = q - middle
                        if inside > 0.0 and limits[3] >= 0.0:
                            sums[e, 2 * MATRIX + 4] = sums[e, 2 * MATRIX + 4] + 1.0  # fitting
                            turn = arm.cross(n)
                            before = R.transpose() @ n
                            zoom = n[0] * there[0] + n[1] * there[1] - before[0] * p[0] - before[1] * p[1]
                            d = vec7(turn[0], turn[1], turn[2], n[0], n[1], n[2], zoom)
                            _add(sums, e, 0, d, (inside / (spread * ti.max(limits[3], 1.0))) ** 2, residual)
                        if images.shape[0] > 0:
                            a, b = ti.floor(x, ti.i32), ti.floor(y, ti.i32)
                            if 0 <= a < width - 1 and 0 <= b < height - 1:
                                fa, fb = x - a, y - b
                                i00, i01 = images[j, b, a], images[j, b, a + 1]
                                i10, i11 = images[j, b + 1, a], images[j, b + 1, a + 1]
                                tone = (1 - fb) * ((1 - fa) * i00 + fa * i01) + fb * ((1 - fa) * i10 + fa * i11)
                                off = tone - tones[at]
                                if ti.abs(off) < 1e6:  # of NaN it is not true
                                    k = 2 * MATRIX + 5
                                    sums[e, k] = sums[e, k] + 1.0
                                    sums[e, k + 1] = sums[e, k + 1] + ti.cast(tone * tones[at], ti.f64)
                                    sums[e, k + 2] = sums[e, k + 2] + ti.cast(tone * tone, ti.f64)
                                    sums[e, k + 3] = sums[e, k + 3] + ti.cast(tones[at] * tones[at], ti.f64)
                                    sums[e, k + 4] = sums[e, k + 4] + ti.cast(ti.abs(off), ti.f64)
                                    du = (1 - fb) * (i01 - i00) + fb * (i11 - i10)
                                    dv = (1 - fa) * (i10 - i00) + fa * (i11 - i01)
                                    gx = du * lens[0] / (stride * q[2] * limits[6])
                                    gy = dv * lens[1] / (stride * q[2] * limits[6])
                                    slope = vec3(gx, gy, -(gx * q[0] + gy * q[1]) / q[2])
                                    if limits[4] > 0.0 and limits[3] >= 0.0:
                                        turn = arm.cross(slope)
                                        before = R.transpose() @ slope
                                        zoom = gx * q[0] + gy * q[1] - before[0] * p[0] - before[1] * p[1]
                                        d = vec7(turn[0], turn[1], turn[2], slope[0], slope[1], slope[2], zoom)
                                        ratio = off / (2.4 * limits[4])
                                        weight = 1.0 / (limits[4] * limits[4] * (1.0 + ratio * ratio))
                                        _add(sums, e, MATRIX, d, weight, off)
