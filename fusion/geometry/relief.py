# mypy: ignore-errors
"""Points and normals of a depth image on Taichi, eight pixels side by side.

Normals come from a smoothed copy: averages along rows, then along columns, over neighbours of about the same depth.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.compute.choice import either
from fusion.compute.language import F32, func, kernel, ti
from fusion.compute.spare import Spare
from fusion.compute.start import start
from fusion.geometry.camera import Camera
from fusion.geometry.lanes import LANES, eight, high, low, put

RADIUS = 4  # of the smoothing [px]
WIDTH = RADIUS / 1.5  # standard deviation of its weights [px]
TAPS = [k for k in range(-RADIUS, RADIUS + 1) if k]
GAUSS = [float(np.exp(-0.5 * (k / WIDTH) ** 2)) for k in range(RADIUS + 1)]
REACH = 2  # of the differences that make a normal, to either side [px]
NEIGHBOURS = 2.0  # steps beyond which a neighbour is on another surface
STEEP = 5.7  # a surface seen at 80 degrees changes its depth by as many pixel widths from one pixel to the next
NOTHING = -1e3  # stands for a missing depth: far from every other
ARCCOS = (1.5707963050, -0.2145988016, 0.0889789874, -0.0501743046, 0.0308918810, -0.0170881256, 0.0066700901,
          -0.0012624911)  # fmt: skip

# planes: x/z and y/z of the pixels, measured depth, its average along rows, along columns too, and angle of the normal
X, Y, DEPTH, ALONG, SMOOTH, ANGLE = range(6)


@dataclass(frozen=True)
class _Planes:
    """Flat images with a margin: pixel (v, u) is entry (v + RADIUS) * stride + LANES + u."""

    # all six, one behind the other, as kernels take them: X, Y, DEPTH, ALONG, SMOOTH and ANGLE
    flat: NDArray[np.float32]
    images: NDArray[np.float32]  # (6, h, w) views of what lies within the margins
    across: int  # groups of eight pixels per row


def _planes(camera: Camera) -> _Planes:
    across = -(-camera.width // LANES) + 2
    planes = np.empty((6, camera.height + 2 * RADIUS, across * LANES), np.float32)
    planes[:] = np.array([0, 0, np.nan, NOTHING, np.nan, np.nan], np.float32)[:, None, None]
    images = planes[:, RADIUS:-RADIUS, LANES : LANES + camera.width]
    images[X], images[Y] = camera.rays()[..., 0], camera.rays()[..., 1]
    return _Planes(planes.reshape(-1), images, across)


_spare = Spare(_planes, most=4)  # for the next frame


@either
def relief(
    depth: NDArray[np.float32], camera: Camera, sigma: NDArray[np.float32], step: float
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Points (h, w, 3) [m] of a depth image (h, w) [m], unit normals (h, w, 3) towards the camera, and the angle (h, w)
    between each normal and its line of sight [rad].

    Normals and angles are NaN where a neighbour two pixels away is missing, and beside holes and steps.

    Args:
        depth: NaN where missing.
        sigma: (h, w) standard deviation of the depth [m].
        step: differences of depth above about this are steps, not noise [m].
    """
    start()
    both = np.full((2, *camera.shape, 3), np.nan, np.float32)
    with _spare.taken(camera) as planes:
        planes.images[DEPTH] = depth
        planes.images[ANGLE] = np.nan
        flat, across = planes.flat, planes.across
        _smooth(flat, across, camera.height, 1 / (NEIGHBOURS * step))
        _differentiate(flat, across, *camera.shape, STEEP / camera.fx, sigma.reshape(-1), both.reshape(-1))
        return both[0], both[1], planes.images[ANGLE].copy()


@func
def _shifted(before: ti.template(), here: ti.template(), after: ti.template(), by: ti.template()):
    """Eight pixels `by` to the right of `here`, by from -8 to 8, of three groups in a row."""
    return ti.Vector([(before, here, after)[(e + by + 8) // 8][(e + by) % 8] for e in range(LANES)])


@func
def _beside(image: ti.template(), g: ti.i32, here: ti.template(), by: ti.template()):
    """The pixels `by` to the left and to the right of group g, whose own are `here`."""
    before, after = eight(image, g - 1), eight(image, g + 1)
    return _shifted(before, here, after, -by), _shifted(before, here, after, by)


@func
def _alike(other: ti.template(), here: ti.template(), gain: ti.f32):
    """Weights from 1 to 0 (Tukey's biweight) of pixels by the difference of their depth."""
    t = (other - here) * gain
    w = 1.0 - t * t
    return ti.select(w > 0.0, w * w, 0.0)


@func
def _arccos(cosine: ti.template()):
    """Of numbers from 0 to 1, side by side; 0 and pi / 2 beyond. To 3e-8: Abramowitz and Stegun 1964, 4.4.46."""
    c = low(1.0, high(0.0, cosine))  # of NaN the second one is kept
    total = ti.Vector([ARCCOS[-1]] * LANES)
    for a in ti.static(ARCCOS[-2::-1]):
        total = total * c + a
    return ti.sqrt(1.0 - c) * total


@kernel
def _smooth(planes: F32, across: ti.i32, height: ti.i32, gain: ti.f32):
    size = (height + 2 * RADIUS) * across  # of a plane, in groups
    for n in range(height * across):
        g = n + RADIUS * across
        here = eight(planes, DEPTH * size + g)
        here = ti.select(here > 0.0, here, NOTHING)
        if n % across > 0 and n % across < across - 1 and here.max() > 0.0:
            before, after = eight(planes, DEPTH * size + g - 1), eight(planes, DEPTH * size + g + 1)
            before, after = ti.select(before > 0.0, before, NOTHING), ti.select(after > 0.0, after, NOTHING)
            weights, total = ti.Vector([1.0] * LANES), here
            for k in ti.static(TAPS):
                other = _shifted(before, here, after, k)
                w = _alike(other, here, gain) * GAUSS[abs(k)]
                weights += w
                total += w * other
            here = total / weights
        for e in ti.static(range(LANES)):
            planes[((ALONG * size + g) << 3) | e] = here[e]
    for n in range(height * across):
        g = n + RADIUS * across
        here = eight(planes, ALONG * size + g)
        if here.max() > 0.0:
            weights, total = ti.Vector([1.0] * LANES), here
            for k in ti.static(TAPS):
                other = eight(planes, ALONG * size + g + k * across)
                w = _alike(other, here, gain) * GAUSS[abs(k)]
                weights += w
                total += w * other
            here = total / weights
        here = ti.select(here > 0.0, here, ti.math.nan)
        for e in ti.static(range(LANES)):
            planes[((SMOOTH * size + g) << 3) | e] = here[e]


@kernel
def _differentiate(planes: F32, across: ti.i32, height: ti.i32, width: ti.i32, steep: ti.f32, sigma: F32, both: F32):
    size = (height + 2 * RADIUS) * across
    for n in range(height * across):
        g = n + RADIUS * across
        v, u = n // across, n % across * LANES - LANES
        z = eight(planes, DEPTH * size + g)
        if 0 <= u < width and z.max() > 0.0:
            o = v * width + u
            s = ti.Vector([sigma[ti.min(o + e, height * width - 1)] for e in ti.static(range(LANES))])
            x, y = eight(planes, X * size + g), eight(planes, Y * size + g)
            x0, x1 = _beside(planes, X * size + g, x, REACH)
            y0, y1 = _beside(planes, Y * size + g, y, REACH)
            z0, z1 = _beside(planes, SMOOTH * size + g, eight(planes, SMOOTH * size + g), REACH)
            ax, ay, az = x1 * z1 - x0 * z0, y1 * z1 - y0 * z0, z1 - z0
            up, down = g - REACH * across, g + REACH * across
            z0, z1 = eight(planes, SMOOTH * size + up), eight(planes, SMOOTH * size + down)
            bx = eight(planes, X * size + down) * z1 - eight(planes, X * size + up) * z0
            by = eight(planes, Y * size + down) * z1 - eight(planes, Y * size + up) * z0
            bz = z1 - z0
            nx, ny, nz = by * az - bz * ay, bz * ax - bx * az, bx * ay - by * ax
            length = 1.0 / ti.sqrt(nx * nx + ny * ny + nz * nz)
            # beside a hole or a step there is no normal; of NaN no comparison is true
            limit = steep * z + 3.0 * s
            left, right = _beside(planes, DEPTH * size + g, z, 1)
            length = ti.select(ti.abs(left - z) < limit, length, ti.math.nan)
            length = ti.select(ti.abs(right - z) < limit, length, ti.math.nan)
            length = ti.select(ti.abs(eight(planes, DEPTH * size + g - across) - z) < limit, length, ti.math.nan)
            length = ti.select(ti.abs(eight(planes, DEPTH * size + g + across) - z) < limit, length, ti.math.nan)
            nx, ny, nz = nx * length, ny * length, nz * length
            put(planes, (ANGLE * size + g) << 3, _arccos(-(x * nx + y * ny + nz) / ti.sqrt(x * x + y * y + 1.0)))
            for e in ti.static(range(LANES)):
                if u + e < width:
                    p, q = (o + e) * 3, (height * width + o + e) * 3  # points first, then normals
                    both[p], both[p + 1], both[p + 2] = x[e] * z[e], y[e] * z[e], z[e]
                    both[q], both[q + 1], both[q + 2] = nx[e], ny[e], nz[e]
