# mypy: ignore-errors
"""The plane that touches the measured surface at every pixel.

In the image, one over the depth of a plane is linear. A pixel amid eight others on the same surface takes the slopes
from all nine, and its depth as the mean of itself and, half of the weight, its four neighbours: about as quiet as
interpolating between four pixels, at a fourth of the look-ups. A plane is given by `level`, one over its depth at the
pixel's centre, `slopes`, by how much that grows per pixel along u and v, and `scales`: a point at depth z is in front
of it by the first scale * (1 - z / the plane's depth where the point lies in the image); the second is the weight.
Slopes and scales are pairs in one number, each kept to one part in 256: half as much to look up.
"""

import taichi as ti

from fusion.geometry.lanes import eight, high, low
from fusion.volume.blocks import F32, F32_2, I32
from fusion.volume.frame import CELL, NOWHERE, PAD

STEEP = 0.1  # least slant, about 84 degrees: beyond, depth says nothing about it (guess)
EDGE = 0.5  # slant of pixels without neighbours (guess)
EDGE_WEIGHT = 0.01  # of pixels beside a jump in depth: they fill in only what no other pixel sees


@ti.func
def pair(a: ti.f32, b: ti.f32) -> ti.i32:
    """Two numbers in one."""
    return _rounded(a) | ((_rounded(b) >> 16) & 0xFFFF)


@ti.func
def _rounded(a: ti.f32) -> ti.i32:
    return (ti.bit_cast(a, ti.i32) + 0x8000) & -0x10000


@ti.func
def first(pair: ti.i32) -> ti.f32:
    """The first of a pair."""
    return ti.bit_cast(pair & -0x10000, ti.f32)


@ti.func
def second(pair: ti.i32) -> ti.f32:
    """The second of a pair."""
    return ti.bit_cast(pair << 16, ti.f32)


@ti.func
def _row(image: ti.template(), g: ti.i32):
    """The pixels to the left of those of group g, they themselves, and those to the right."""
    a, b, c = image[(g << 3) - 1], eight(image, g), image[(g << 3) + 8]
    left = ti.Vector([a] + [b[e] for e in range(7)])
    return left, b, ti.Vector([b[e + 1] for e in range(7)] + [c])


@ti.func
def _half(here: ti.template(), before: ti.template(), after: ti.template(), truncation: ti.f32):
    """Slope from the sides that lie on the same surface, and how many there are."""
    one = (before > 0.0) & (ti.abs(before - here) < truncation * before * here)
    other = (after > 0.0) & (ti.abs(after - here) < truncation * after * here)
    sides = ti.select(one, 1.0, 0.0) + ti.select(other, 1.0, 0.0)
    step = ti.select(other, after, here) - ti.select(one, before, here)
    return step / high(sides, 1.0), sides


@ti.kernel
def measure_planes(
    inverse: F32, x: F32, y: F32, bend: F32, farthest: F32_2, fx: ti.f32, fy: ti.f32, truncation: ti.f32,
    weight: F32, level: F32, slopes: I32, scales: I32, filled: I32, distorted: ti.template(), weighted: ti.template(),
):  # fmt: skip
    """Fills the planes from one over depth; the weight is the slant, the distance to the plane per difference in z,
    times the pixel's own, and 0 where there is no depth."""
    rows = farthest.shape[0] * CELL
    across = inverse.shape[0] // (rows + 2 * PAD) // 8
    for m in range(rows * across):  # eight pixels at a time
        deep = 0.0
        if m % across * 2 < farthest.shape[1]:
            deep = farthest[m // across // CELL, m % across * 2] + farthest[m // across // CELL, m % across * 2 + 1]
        if deep > 0.0 or filled[m] == 1:  # else it is empty and stays so
            filled[m] = ti.select(deep > 0.0, 1, 0)
            g = m + PAD * across
            i, du, dv = ti.Vector([NOWHERE] * 8), ti.Vector([0.0] * 8), ti.Vector([0.0] * 8)
            gain, w = ti.Vector([0.0] * 8), ti.Vector([0.0] * 8)
            if deep > 0.0:
                ul, u, ur = _row(inverse, g - across)
                cl, c, cr = _row(inverse, g)
                dl, d, dr = _row(inverse, g + across)
                lowest = low(low(low(low(ul, u), low(ur, cl)), low(low(c, cr), low(dl, d))), dr)
                highest = high(high(high(high(ul, u), high(ur, cl)), high(high(c, cr), high(dl, d))), dr)
                jump = high(highest - c - truncation * highest * c, c - lowest - truncation * lowest * c)
                du = ((ur - ul) + (cr - cl) + (dr - dl)) * (1.0 / 6.0)
                dv = ((dl - ul) + (d - u) + (dr - ur)) * (1.0 / 6.0)
                i = c + ((u + d) + (cl + cr) - 4.0 * c) * 0.125
                least = ti.Vector([STEEP] * 8)
                if jump.max() >= 0.0:
                    i = ti.select(jump < 0.0, i, c)
                    du_half, sides_u = _half(c, cl, cr, truncation)
                    dv_half, sides_v = _half(c, u, d, truncation)
                    du = ti.select(jump < 0.0, du, du_half)
                    dv = ti.select(jump < 0.0, dv, dv_half)
                    least = ti.select(low(sides_u, sides_v) < 0.5, EDGE, STEEP)
                A, B = du * fx, dv * fy
                if ti.static(distorted):  # pixels are no steps along x or y alone
                    n = inverse.shape[0] // 8
                    A = du * eight(bend, g) + dv * eight(bend, g + n)
                    B = du * eight(bend, g + 2 * n) + dv * eight(bend, g + 3 * n)
                C = i - A * eight(x, g) - B * eight(y, g)
                slant = high(i / ti.sqrt(A * A + B * B + C * C), least)
                w = ti.select(jump < 0.0, slant, slant * EDGE_WEIGHT)
                if ti.static(weighted):
                    w *= eight(weight, g)
                w = ti.select(c > 0.0, w, 0.0)
                gain = ti.select(c > 0.0, slant / i, 0.0)
                i = ti.select(c > 0.0, i, NOWHERE)
            for e in ti.static(range(8)):
                level[(g << 3) | e] = i[e]
            for e in ti.static(range(8)):
                slopes[(g << 3) | e] = pair(du[e], dv[e])
            for e in ti.static(range(8)):
                scales[(g << 3) | e] = pair(gain[e], w[e])
