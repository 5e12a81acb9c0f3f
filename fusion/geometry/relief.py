# mypy: ignore-errors
"""Points and normals of a depth image on Taichi, eight pixels side by side.

Normals come from a smoothed copy: averages along rows, then along columns, over neighbours of about the same depth.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from fusion import compute
from fusion.geometry.camera import Camera
from fusion.geometry.lanes import LANES, eight

RADIUS = 4  # of the smoothing [px]
WIDTH = RADIUS / 1.5  # standard deviation of its weights [px]
TAPS = [k for k in range(-RADIUS, RADIUS + 1) if k]
GAUSS = [float(np.exp(-0.5 * (k / WIDTH) ** 2)) for k in range(RADIUS + 1)]
STRIP = 32  # pixels of a row that are looked at in turn
REACH = 2  # of the differences that make a normal, to either side [px]
NEIGHBOURS = 2.0  # steps beyond which a neighbour is on another surface
STEEP = 5.7  # a surface seen at 80 degrees changes its depth by as many pixel widths from one pixel to the next
NOTHING = -1e3  # stands for a missing depth: far from every other
F32 = ti.types.ndarray(dtype=ti.f32, ndim=1)

# planes: x/z and y/z of the pixels, the measured depth, its average along rows, and along columns too
X, Y, DEPTH, ALONG, SMOOTH = range(5)


@dataclass(frozen=True)
class _Planes:
    """Flat images with a margin: pixel (v, u) is entry (v + RADIUS) * stride + LANES + u.

    Attributes:
        flat: all five, one behind the other, as kernels take them: X, Y, DEPTH, ALONG and SMOOTH.
        images: (5, h, w) views of what lies within the margins.
        across: groups of eight pixels per row.
    """

    flat: NDArray[np.float32]
    images: NDArray[np.float32]
    across: int


@lru_cache(maxsize=4)
def _planes(camera: Camera) -> _Planes:
    """Kept for the next frame: fresh memory would cost more than filling it."""
    across = -(-camera.width // LANES) + 2
    planes = np.empty((5, camera.height + 2 * RADIUS, across * LANES), np.float32)
    planes[:] = np.array([0, 0, np.nan, NOTHING, np.nan], np.float32)[:, None, None]
    images = planes[:, RADIUS:-RADIUS, LANES : LANES + camera.width]
    images[X], images[Y] = camera.rays()[..., 0], camera.rays()[..., 1]
    return _Planes(planes.reshape(-1), images, across)


def relief(
    depth: NDArray[np.float32], camera: Camera, sigma: NDArray[np.float32], step: float
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Points (h, w, 3) [m] of a depth image (h, w) [m], and unit normals (h, w, 3) towards the camera.

    Normals are NaN where a neighbour two pixels away is missing, and beside holes and steps.

    Args:
        depth: NaN where missing.
        camera: its camera.
        sigma: (h, w) standard deviation of the depth [m].
        step: differences of depth above about this are steps, not noise [m].
    """
    compute.start()
    planes = _planes(camera)
    planes.images[DEPTH] = depth
    both = np.full((2, *camera.shape, 3), np.nan, np.float32)
    _smooth(planes.flat, planes.across, camera.height, 1 / (NEIGHBOURS * step))
    _differentiate(planes.flat, planes.across, *camera.shape, STEEP / camera.fx, sigma.reshape(-1), both.reshape(-1))
    return both[0], both[1]


def incidence(points: NDArray[np.float32], normals: NDArray[np.float32]) -> NDArray[np.float32]:
    """Angle (h, w) between lines of sight to points (h, w, 3) [m] and normals (h, w, 3) [rad]; NaN where unknown."""
    compute.start()
    angle = np.empty(points.shape[:2], np.float32)
    p, n = (np.ascontiguousarray(image, np.float32).reshape(-1) for image in (points, normals))
    _tilt(p, n, angle.reshape(-1))
    return angle


@ti.kernel
def _tilt(points: F32, normals: F32, angle: F32):
    for i in angle:
        p = ti.Vector([points[3 * i], points[3 * i + 1], points[3 * i + 2]])
        n = ti.Vector([normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]])
        cosine = -p.dot(n) / p.norm()
        found = ti.math.nan
        if cosine == cosine:
            found = ti.acos(ti.min(ti.max(cosine, -1.0), 1.0))
        angle[i] = found


@ti.func
def _shifted(before: ti.template(), here: ti.template(), after: ti.template(), by: ti.template()):
    """Eight pixels `by` to the right of `here`, by from -8 to 8, of three groups in a row."""
    return ti.Vector([(before, here, after)[(e + by + 8) // 8][(e + by) % 8] for e in range(LANES)])


@ti.func
def _alike(other: ti.template(), here: ti.template(), gain: ti.f32):
    """Weights from 1 to 0 (Tukey's biweight) of pixels by the difference of their depth."""
    t = (other - here) * gain
    w = 1.0 - t * t
    return ti.select(w > 0.0, w * w, 0.0)


@ti.kernel
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


@ti.kernel
def _differentiate(planes: F32, across: ti.i32, height: ti.i32, width: ti.i32, steep: ti.f32, sigma: F32, both: F32):
    stride, strips = across * LANES, (width + STRIP - 1) // STRIP
    size = (height + 2 * RADIUS) * stride
    for n in range(height * strips):
        v, u = n // strips, n % strips * STRIP
        at, o, count = (v + RADIUS) * stride + LANES + u, v * width + u, ti.min(STRIP, width - u)
        some = False
        for s in range(count):
            some |= planes[DEPTH * size + at + s] > 0.0
        if some:
            nx, ny, nz = ti.Vector([0.0] * STRIP), ti.Vector([0.0] * STRIP), ti.Vector([0.0] * STRIP)
            for s in range(STRIP):  # without branches: the compiler makes vectors of it
                p, z = at + s, planes[DEPTH * size + at + s]
                a = _surface(planes, size, p + REACH) - _surface(planes, size, p - REACH)
                b = _surface(planes, size, p + REACH * stride) - _surface(planes, size, p - REACH * stride)
                m = b.cross(a)
                # beside a hole or a step there is no normal; of NaN no comparison is true
                limit = steep * z + 3.0 * sigma[ti.min(o + s, height * width - 1)]
                left, right = planes[DEPTH * size + p - 1], planes[DEPTH * size + p + 1]
                up, down = planes[DEPTH * size + p - stride], planes[DEPTH * size + p + stride]
                whole = (ti.abs(left - z) < limit) & (ti.abs(right - z) < limit)
                whole &= (ti.abs(up - z) < limit) & (ti.abs(down - z) < limit)
                length = ti.select(whole, 1.0 / ti.sqrt(m.dot(m)), ti.math.nan)
                nx[s], ny[s], nz[s] = m[0] * length, m[1] * length, m[2] * length
            for s in range(count):
                p, q = (o + s) * 3, (height * width + o + s) * 3  # points first, then normals
                z = planes[DEPTH * size + at + s]
                both[p], both[p + 1], both[p + 2] = planes[at + s] * z, planes[size + at + s] * z, z
                both[q], both[q + 1], both[q + 2] = nx[s], ny[s], nz[s]


@ti.func
def _surface(planes: ti.template(), size: ti.i32, at: ti.i32):
    """The smoothed point (3,) of an entry."""
    z = planes[SMOOTH * size + at]
    return ti.Vector([planes[X * size + at] * z, planes[Y * size + at] * z, z])
