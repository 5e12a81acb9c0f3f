# mypy: ignore-errors
"""Projective point-to-plane pairs and their normal equations in one pass over the source points, on Taichi."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.compute.choice import either
from fusion.compute.language import F32, func, kernel, ti
from fusion.compute.start import start
from fusion.geometry.depth import PointMap
from fusion.geometry.lanes import LANES, gather, high, low, project
from fusion.geometry.robust import CUT, MAD_TO_STD

Array = NDArray[np.float64]

SUMS = 32  # 21 of the matrix, 6 of the slope; weights, squares, kept, pairs, visible points, squared misfits
SAMPLE = 2000  # residuals that a median is taken of: known to 3 %
NUMBERS = 40  # at the start of the kernel's numbers, the rest is what comes out
# largest difference of four pixels' depths in pixel widths: a surface seen at 80 degrees changes by 5.7 from one to the
# next, twice that across
STEEP = 12.0
LATERAL = 0.29  # standard deviation of where in its pixel a depth comes from, all places being alike [px]
# where the upper and the lower triangle of the information stand among the sums
_FULL = np.array([[max(i, j) * (max(i, j) + 1) // 2 + min(i, j) for j in range(6)] for i in range(6)])


@dataclass(frozen=True)
class Points:
    """Source points laid out for the kernel."""

    lanes: NDArray[np.float32]  # (groups, 7, 8) x, y, z, normal [m], sigma [m]; sigma is -1 where a group is not full
    count: int  # number of points
    centre: Array  # (3,) their centroid [m]
    radius: float  # their rms distance from it [m]


@dataclass(frozen=True)
class PairLimits:
    """What makes a pair, and how it counts."""

    reach: float  # largest distance of a pair [m]
    min_cosine: float = 0.7  # smallest cosine between the normals of a pair
    scale: float = 1.0  # observed over declared spread of the residuals
    open_to: float = 0.0  # residuals up to about this size count whatever their declared spread [m]


@dataclass(frozen=True)
class Equations:
    """What all pairs say together."""

    information: Array  # (6, 6) of a left twist: rotation about the moved centroid [rad], shift [m]
    slope: Array  # (6,) weighted derivative of half the squared residuals
    weight: float  # sum of the weights
    squares: float  # sum of squared residuals of the pairs kept [m^2]
    # kept, pairs, visible: numbers of pairs with a weight, of pairs, of points that the model could have met
    kept: int
    pairs: int
    visible: int
    scale: float  # observed over declared spread, at least 1


def lay_out(source: PointMap, most: int) -> Points:
    """The points of every n-th pixel in both directions that has a normal and a sigma; about `most` to four times that,
    or all there are."""
    start()
    height, width = source.camera.shape
    known = 64 * int(np.isfinite(source.normals[4::8, 4::8, 0]).sum())
    stride = max(1, int(np.sqrt(known / most)))
    room = (height // stride + 1) * (width // stride + 1) // LANES + 1
    lanes, moments = np.empty((room, 7, LANES), np.float32), np.zeros(5)
    _gather(
        _flat(source.points),
        _flat(source.normals),
        _flat(source.sigma),
        height,
        width,
        stride,
        lanes.reshape(-1),
        moments,
    )
    count = int(moments[0])
    if not count:
        return Points(lanes[:0], 0, np.zeros(3), 0.0)
    centre = moments[1:4] / count
    radius = float(np.sqrt(max(moments[4] / count - centre @ centre, 0.0)))
    return Points(lanes[: -(-count // LANES)], count, centre, radius)


def thinned(points: Points, most: int) -> Points:
    """Every n-th group, about `most` points or a few more."""
    step = max(1, points.count // most)
    return replace(points, lanes=np.ascontiguousarray(points.lanes[::step]), count=-(-points.count // step))


@either
def equations(source: Points, T_model_source: Array, model: PointMap, limits: PairLimits) -> Equations:
    """Pair the source with the model at a pose (4, 4), and sum up the pairs' equations r = n . (moved - met).

    The model's depth is interpolated between four pixels, so that its pixels' raster leaves no mark in the residuals;
    where the four do not lie on one surface, nothing is met.
    """
    start()
    groups = len(source.lanes)
    if not groups or min(model.camera.shape) < 2:
        return Equations(np.zeros((6, 6)), np.zeros(6), 0.0, 0.0, 0, 0, 0, 1.0)
    centre = T_model_source[:3, :3] @ source.centre + T_model_source[:3, 3]
    # one array for all numbers that go in and out: the launch takes longer for each argument than the kernel for a pair
    work = np.empty(NUMBERS + groups * (SUMS + LANES), np.float32)
    work[:12], work[12:15], work[15:27] = T_model_source[:3].ravel(), centre, model.camera.parameters
    work[27:33] = (*model.camera.shape, limits.reach, limits.min_cosine, limits.scale, limits.open_to)
    _accumulate(
        source.lanes.reshape(-1), _flat(model.points), _flat(model.normals), _flat(model.sigma),
        any(model.camera.distortion), work,
    )  # fmt: skip
    sums = work[NUMBERS : NUMBERS + groups * SUMS].reshape(groups, SUMS)
    ratio = work[NUMBERS + groups * SUMS :]
    total = sums.sum(axis=0, dtype=float)
    information = total[_FULL]
    some = ratio[:: max(1, source.count // SAMPLE)]
    some = some[some >= 0]
    scale = MAD_TO_STD * float(np.partition(some, len(some) // 2)[len(some) // 2]) if len(some) else 1.0
    weight, squares, kept, pairs, visible = total[27:32]
    return Equations(
        information, total[21:27], float(weight), float(squares), int(kept), int(pairs), int(visible), max(1.0, scale)
    )


def _flat(image: NDArray) -> NDArray[np.float32]:
    return np.ascontiguousarray(image, np.float32).reshape(-1)


@kernel
def _gather(
    points: F32, normals: F32, sigma: F32, height: ti.i32, width: ti.i32, stride: ti.i32, lanes: F32,
    moments: ti.types.ndarray(dtype=ti.f64, ndim=1),
):  # fmt: skip
    ti.loop_config(serialize=True)
    for _ in range(1):
        count = 0
        total = ti.Vector([0.0, 0.0, 0.0, 0.0], ti.f64)
        v = stride // 2
        while v < height:
            u = stride // 2
            while u < width:
                at = v * width + u
                if normals[at * 3] < 2.0:  # of NaN it is not true
                    s = sigma[at]
                    x, y, z = points[at * 3], points[at * 3 + 1], points[at * 3 + 2]
                    if s >= 0.0 and z > 0.0:
                        o = (count >> 3) * 56 + (count & 7)
                        lanes[o], lanes[o + 8], lanes[o + 16] = x, y, z
                        for k in ti.static(range(3)):
                            lanes[o + 24 + 8 * k] = normals[at * 3 + k]
                        lanes[o + 48] = s
                        total += ti.Vector([x, y, z, x * x + y * y + z * z])
                        count += 1
                u += stride
            v += stride
        moments[0] = count
        for k in ti.static(range(4)):
            moments[k + 1] = total[k]
        while count & 7:
            o = (count >> 3) * 56 + (count & 7)
            for k in ti.static(range(6)):
                lanes[o + 8 * k] = 0.0
            lanes[o + 48] = -1.0
            count += 1


@func
def _sum_up(work: ti.template(), o: ti.i32, weight: ti.template(), J: ti.template(), r: ti.template()):
    """Matrix and slope of eight equations, and their weight, to the first of their SUMS."""
    for row in ti.static(range(6)):
        wJ = weight * J[row]
        for col in ti.static(range(row + 1)):
            work[o + row * (row + 1) // 2 + col] = (wJ * J[col]).sum()
        work[o + 21 + row] = (wJ * r).sum()
    work[o + 27] = weight.sum()


@func
def _depth_there(points: ti.template(), at: ti.template(), width: ti.i32, du: ti.template(), dv: ti.template()):
    """Depth [m] between four pixels, the first of them at a place, NaN where one is missing; and how much they differ:
    inverse depth is linear in the image on a plane."""
    here = at * 3 + 2
    z00, z01 = gather(points, here), gather(points, here + 3)
    z10, z11 = gather(points, here + width * 3), gather(points, here + width * 3 + 3)
    lowest, highest = low(low(z00, z01), low(z10, z11)), high(high(z00, z01), high(z10, z11))
    upper, lower = 1.0 / z00 + (1.0 / z01 - 1.0 / z00) * du, 1.0 / z10 + (1.0 / z11 - 1.0 / z10) * du
    return 1.0 / (upper + (lower - upper) * dv), highest - lowest


@kernel
def _accumulate(source: F32, points: F32, normals: F32, sigma: F32, distorted: ti.template(), work: F32):
    groups = source.shape[0] // (7 * LANES)
    for g in range(groups):
        T = ti.Vector([work[k] for k in ti.static(range(12))])
        c = ti.Vector([work[15 + k] for k in ti.static(range(12))])
        bottom, right, reach, min_cosine, scale, open_to = (
            work[27] - 1.0, work[28] - 1.0, work[29], work[30], work[31], work[32],
        )  # fmt: skip
        width = ti.cast(work[28], ti.i32)
        p = [ti.Vector([source[((g * 7 + k) << 3) | e] for e in ti.static(range(LANES))]) for k in ti.static(range(7))]
        q = [T[4 * k] * p[0] + T[4 * k + 1] * p[1] + T[4 * k + 2] * p[2] + T[4 * k + 3] for k in ti.static(range(3))]
        m = [T[4 * k] * p[3] + T[4 * k + 1] * p[4] + T[4 * k + 2] * p[5] for k in ti.static(range(3))]
        near = 1.0 / high(q[2], 1e-3)
        u, v = project(q[0] * near, q[1] * near, c, distorted)
        uc, vc = low(high(u, 0.0), right), low(high(v, 0.0), bottom)
        aside = ti.abs(u - uc) + ti.abs(v - vc)  # beyond the outermost pixels' centres
        ua, va = ti.cast(low(uc, right - 0.5), ti.i32), ti.cast(low(vc, bottom - 0.5), ti.i32)
        du, dv = uc - ti.cast(ua, ti.f32), vc - ti.cast(va, ti.f32)
        at = va * width + ua
        z, difference = _depth_there(points, at, width, du, dv)
        nearest = at + ti.select(dv < 0.5, 0, width) + ti.select(du < 0.5, 0, 1)
        n = [gather(normals, nearest * 3 + k) for k in ti.static(range(3))]
        other = gather(sigma, nearest)
        # of NaN no comparison is true; z is NaN where one of the four is
        seen = ti.select(z > 0.0, 1.0, 0.0) * ti.select(difference < STEEP / c[0] * z, 1.0, 0.0)
        seen *= ti.select(q[2] > 0.05, 1.0, 0.0) * ti.select(aside <= 0.0, 1.0, 0.0) * ti.select(p[6] >= 0.0, 1.0, 0.0)
        length = ti.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2])
        behind = 1.0 - z * near
        nq = n[0] * q[0] + n[1] * q[1] + n[2] * q[2]
        r = nq * behind
        paired = seen * ti.select(ti.abs(behind) * length < reach, 1.0, 0.0)
        paired *= ti.select(m[0] * n[0] + m[1] * n[1] + m[2] * n[2] > min_cosine, 1.0, 0.0)
        # depth noise acts along the line of sight: seen along the normal it shrinks by the cosine
        other = ti.select(other > 0.0, other, 0.0)
        cosine = nq / length
        # across it, the depth of a pixel may come from anywhere in it
        aslant = (1.0 - cosine * cosine) * (q[2] * q[2]) * (LATERAL * LATERAL / (c[0] * c[0]))
        spread = ti.sqrt(cosine * cosine * (p[6] * p[6] + other * other) + aslant + 1e-10)
        yes = paired > 0.0
        odds = ti.abs(r) / spread
        spread *= scale
        t = r / high(spread * CUT, open_to)
        shape = high(1.0 - t * t, 0.0)
        weight = ti.select(yes, shape * shape / (spread * spread), 0.0)
        r = ti.select(yes, r, 0.0)
        f = [ti.select(yes, n[k], 0.0) for k in ti.static(range(3))]
        a = [q[k] - work[12 + k] for k in ti.static(range(3))]
        J = [a[1] * f[2] - a[2] * f[1], a[2] * f[0] - a[0] * f[2], a[0] * f[1] - a[1] * f[0], f[0], f[1], f[2]]
        kept = ti.select(weight > 0.0, 1.0, 0.0)
        o = NUMBERS + g * SUMS
        _sum_up(work, o, weight, J, r)
        work[o + 28] = (kept * r * r).sum()
        work[o + 29] = kept.sum()
        work[o + 30] = paired.sum()
        work[o + 31] = seen.sum()
        odds = ti.select(yes, odds, -1.0)
        for e in ti.static(range(LANES)):
            work[NUMBERS + groups * SUMS + g * LANES + e] = odds[e]
