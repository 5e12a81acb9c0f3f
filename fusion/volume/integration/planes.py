# mypy: ignore-errors
"""The plane that touches the measured surface at every pixel, and its weight.

In the image, one over the depth of a plane is linear. A pixel amid eight others on the same surface takes the slopes
from all nine, and its depth as the mean of itself and, half of the weight, its four neighbours: about as quiet as
interpolating between four pixels, at a fourth of the look-ups. A plane is given by `level`, one over its depth at the
pixel's centre, `slopes`, by how much that grows per pixel along u and v, and `scales`: a point at depth z is in front
of it by the first scale * (1 - z / the plane's depth where the point lies in the image); the second is the weight.
Slopes and scales are pairs in one number, each kept to one part in 256: half as much to look up.
"""

from typing import NamedTuple

from fusion.compute.language import F32, I32, func, kernel, ti
from fusion.geometry.lanes import bounded, eight, high, low, put
from fusion.volume.integration.frame import CELL, NOWHERE, PAD, STRIP

STEEP = 0.1  # least slant, about 84 degrees: beyond, depth says nothing about it (guess)
EDGE = 0.5  # slant of pixels without neighbours (guess)
# of pixels beside a jump in depth: they fill in only what no other pixel sees (`DOUBT` of sensor/weights for effects)
EDGE_WEIGHT = 0.01


class Inverse(NamedTuple):
    """One over depth, and weight, of a frame of `across` strips, see `Work`."""

    inverse: F32
    weight: F32
    filled: I32
    across: ti.i32


class Slants(NamedTuple):
    """Directions of a camera's pixels, see `Geometry`, and its focal lengths [px]."""

    x: F32
    y: F32
    bend: F32
    fx: ti.f32
    fy: ti.f32


class Planes(NamedTuple):
    """Flat images, see above."""

    level: F32
    slopes: I32
    scales: I32


@func
def pair(a: ti.f32, b: ti.f32) -> ti.i32:
    """Two numbers in one."""
    return _rounded(a) | ((_rounded(b) >> 16) & 0xFFFF)


@func
def _rounded(a: ti.f32) -> ti.i32:
    return (ti.bit_cast(a, ti.i32) + 0x8000) & -0x10000


@func
def first(pair: ti.i32) -> ti.f32:
    """The first of a pair."""
    return ti.bit_cast(pair & -0x10000, ti.f32)


@func
def second(pair: ti.i32) -> ti.f32:
    """The second of a pair."""
    return ti.bit_cast(pair << 16, ti.f32)


@func
def _three(image: ti.template(), at: ti.i32):
    """The pixel to the left, this one, and the one to the right."""
    return image[at - 1], image[at], image[at + 1]


@func
def _half(here: ti.template(), before: ti.template(), after: ti.template(), truncation: ti.f32):
    """Slope from the sides that lie on the same surface, and how many there are."""
    one = (before > 0.0) & (ti.abs(before - here) < truncation * before * here)
    other = (after > 0.0) & (ti.abs(after - here) < truncation * after * here)
    sides = ti.select(one, 1.0, 0.0) + ti.select(other, 1.0, 0.0)
    step = ti.select(other, after, here) - ti.select(one, before, here)
    return step / high(sides, 1.0), sides


@kernel
def measure_planes(
    frame: Inverse, rays: Slants, truncation: ti.f32, out: Planes, distorted: ti.template(), weighted: ti.template()
):
    """Fills the planes from one over depth; the weight is the slant, the distance to the plane per difference in z,
    times the pixel's own, and 0 where there is no depth."""
    inverse, across, x, y, bend = ti.static((frame.inverse, frame.across, rays.x, rays.y, rays.bend))
    # In loops that have no branches and write to arrays of their own: the compiler makes vectors of them.
    for n in range(frame.filled.shape[0] * CELL):
        row, strip = n // across, n % across
        if frame.filled[row // CELL * across + strip] != 0:  # else it is empty and stays so
            stride = bounded(across * STRIP)
            at = bounded((row + PAD) * stride + strip * STRIP)
            i, du, dv = ti.Vector([NOWHERE] * STRIP), ti.Vector([0.0] * STRIP), ti.Vector([0.0] * STRIP)
            jump, least = ti.Vector([0.0] * STRIP), ti.Vector([STEEP] * STRIP)
            signs = -1  # its highest bit stays as long as all jumps are negative
            for s in range(STRIP):
                ul, u, ur = _three(inverse, at + s - stride)
                cl, c, cr = _three(inverse, at + s)
                dl, d, dr = _three(inverse, at + s + stride)
                lowest = low(low(low(low(ul, u), low(ur, cl)), low(low(c, cr), low(dl, d))), dr)
                highest = high(high(high(high(ul, u), high(ur, cl)), high(high(c, cr), high(dl, d))), dr)
                step = high(highest - c - truncation * highest * c, c - lowest - truncation * lowest * c)
                jump[s], signs = step, signs & ti.bit_cast(step, ti.i32)
                du[s] = ((ur - ul) + (cr - cl) + (dr - dl)) * (1.0 / 6.0)
                dv[s] = ((dl - ul) + (d - u) + (dr - ur)) * (1.0 / 6.0)
                i[s] = c + ((u + d) + (cl + cr) - 4.0 * c) * 0.125
            if signs >= 0:
                for s in range(STRIP):
                    cl, c, cr = _three(inverse, at + s)
                    across_u, sides_u = _half(c, cl, cr, truncation)
                    across_v, sides_v = _half(c, inverse[at + s - stride], inverse[at + s + stride], truncation)
                    whole = jump[s] < 0.0
                    i[s] = ti.select(whole, i[s], c)
                    du[s] = ti.select(whole, du[s], across_u)
                    dv[s] = ti.select(whole, dv[s], across_v)
                    least[s] = ti.select(low(sides_u, sides_v) < 0.5, EDGE, STEEP)
            here, slope, scale = ti.Vector([0.0] * STRIP), ti.Vector([0] * STRIP), ti.Vector([0] * STRIP)
            for s in range(STRIP):
                A, B = du[s] * rays.fx, dv[s] * rays.fy
                if ti.static(distorted):  # pixels are no steps along x or y alone
                    m = inverse.shape[0]
                    A = du[s] * bend[at + s] + dv[s] * bend[at + s + m]
                    B = du[s] * bend[at + s + 2 * m] + dv[s] * bend[at + s + 3 * m]
                C = i[s] - A * x[at + s] - B * y[at + s]
                known = inverse[at + s] > 0.0
                slant = high(i[s] / ti.sqrt(A * A + B * B + C * C), least[s])
                w = ti.select(jump[s] < 0.0, slant, slant * EDGE_WEIGHT)
                if ti.static(weighted):
                    w *= frame.weight[at + s]
                slope[s] = pair(du[s], dv[s])
                scale[s] = ti.select(known, pair(slant / i[s], w), 0)
                here[s] = ti.select(known, i[s], NOWHERE)
            for g in range(STRIP // 8):
                o = at + g * 8
                put(out.level, o, eight(here, g))
                put(out.slopes, o, eight(slope, g))
                put(out.scales, o, eight(scale, g))
