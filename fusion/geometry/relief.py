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

LANES = 8
RADIUS = 4  # of the smoothing [px]
WIDTH = RADIUS / 1.5  # standard deviation of its weights [px]
TAPS = [k for k in range(-RADIUS, RADIUS + 1) if k]
GAUSS = [float(np.exp(-0.5 * (k / WIDTH) ** 2)) for k in range(RADIUS + 1)]
REACH = 2  # of the differences that make a normal, to either side [px]
NEIGHBOURS = 2.0  # steps beyond which a neighbour is on another surface
STEEP = 5.7  # a surface seen at 80 degrees changes its depth by as many pixel widths from one pixel to the next
NOTHING = -1e3  # stands for a missing depth: far from every other
F32 = ti.types.ndarray(dtype=ti.f32, ndim=1)

Flat = NDArray[np.float32]


@dataclass(frozen=True)
class _Planes:
    """Flat images with a margin: pixel (v, u) is entry (v + RADIUS) * stride + LANES + u.

    Attributes:
        stride: entries per row, a multiple of LANES.
        x, y: x/z and y/z of every pixel.
        depth, along, smooth: what was measured, averaged along rows, and along columns too [m].
    """

    stride: int
    x: Flat
    y: Flat
    depth: Flat
    along: Flat
    smooth: Flat

    def inside(self, plane: Flat, camera: Camera) -> NDArray[np.float32]:
        """The image (h, w) within a plane."""
        return plane.reshape(-1, self.stride)[RADIUS : RADIUS + camera.height, LANES : LANES + camera.width]


@lru_cache(maxsize=4)
def _planes(camera: Camera) -> _Planes:
    """Kept for the next frame: fresh memory would cost more than filling it."""
    stride = (camera.width + 3 * LANES - 1) // LANES * LANES
    size = stride * (camera.height + 2 * RADIUS)
    planes = _Planes(stride, *(np.full(size, value, np.float32) for value in (0, 0, np.nan, NOTHING, np.nan)))
    rays = camera.rays()
    planes.inside(planes.x, camera)[:], planes.inside(planes.y, camera)[:] = rays[..., 0], rays[..., 1]
    return planes


def relief(
    depth: NDArray[np.float32], camera: Camera, sigma: NDArray[np.float32], step: float
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Points (h, w, 3) [m] of a depth image (h, w) [m], and unit normals (h, w, 3) towards the camera.

    Normals are NaN where a neighbour two pixels away is missing, and beside holes and steps.

    Args:
        depth: NaN where missing.
        camera: its camera.
        sigma: (h, w) standard deviation of the depth [m]; set to NaN where the depth is missing.
        step: differences of depth above about this are steps, not noise [m].
    """
    compute.start()
    planes = _planes(camera)
    planes.inside(planes.depth, camera)[:] = depth
    points, normals = np.empty((2, *camera.shape, 3), np.float32)
    across = planes.stride // LANES
    _smooth(planes.depth, planes.along, planes.smooth, across, camera.height, 1 / (NEIGHBOURS * step))
    _differentiate(
        planes.x, planes.y, planes.depth, planes.smooth, across, *camera.shape, STEEP / camera.fx, sigma.reshape(-1),
        points.reshape(-1), normals.reshape(-1),
    )  # fmt: skip
    return points, normals


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
def _eight(image: ti.template(), g: ti.i32):
    """Pixels 8 g to 8 g + 7: written so that the compiler reads them as one vector."""
    return ti.Vector([image[(g << 3) | e] for e in ti.static(range(LANES))])


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
def _smooth(depth: F32, along: F32, smooth: F32, across: ti.i32, height: ti.i32, gain: ti.f32):
    for n in range(height * across):
        g = n + RADIUS * across
        here = _eight(depth, g)
        here = ti.select(here > 0.0, here, NOTHING)
        if n % across > 0 and n % across < across - 1 and here.max() > 0.0:
            before, after = _eight(depth, g - 1), _eight(depth, g + 1)
            before, after = ti.select(before > 0.0, before, NOTHING), ti.select(after > 0.0, after, NOTHING)
            weights, total = ti.Vector([1.0] * LANES), here
            for k in ti.static(TAPS):
                other = _shifted(before, here, after, k)
                w = _alike(other, here, gain) * GAUSS[abs(k)]
                weights += w
                total += w * other
            here = total / weights
        for e in ti.static(range(LANES)):
            along[(g << 3) | e] = here[e]
    for n in range(height * across):
        g = n + RADIUS * across
        here = _eight(along, g)
        if here.max() > 0.0:
            weights, total = ti.Vector([1.0] * LANES), here
            for k in ti.static(TAPS):
                other = _eight(along, g + k * across)
                w = _alike(other, here, gain) * GAUSS[abs(k)]
                weights += w
                total += w * other
            here = total / weights
        here = ti.select(here > 0.0, here, ti.math.nan)
        for e in ti.static(range(LANES)):
            smooth[(g << 3) | e] = here[e]


@ti.kernel
def _differentiate(
    x: F32, y: F32, depth: F32, smooth: F32, across: ti.i32, height: ti.i32, width: ti.i32, steep: ti.f32, sigma: F32,
    points: F32, normals: F32,
):  # fmt: skip
    for n in range(height * across):
        g = n + RADIUS * across
        v, u = n // across, n % across * LANES - LANES
        if 0 <= u < width:
            here, px, py = _eight(depth, g), _eight(x, g), _eight(y, g)
            o = v * width + u
            s = ti.Vector([sigma[ti.min(o + e, height * width - 1)] for e in ti.static(range(LANES))])
            nx, ny, nz = here, here, here
            if here.max() > 0.0:
                za, zb, zc = _eight(smooth, g - 1), _eight(smooth, g), _eight(smooth, g + 1)
                z0, z1 = _shifted(za, zb, zc, -REACH), _shifted(za, zb, zc, REACH)
                xa, xc, ya, yc = _eight(x, g - 1), _eight(x, g + 1), _eight(y, g - 1), _eight(y, g + 1)
                ax = _shifted(xa, px, xc, REACH) * z1 - _shifted(xa, px, xc, -REACH) * z0
                ay = _shifted(ya, py, yc, REACH) * z1 - _shifted(ya, py, yc, -REACH) * z0
                az = z1 - z0
                up, down = g - REACH * across, g + REACH * across
                z0, z1 = _eight(smooth, up), _eight(smooth, down)
                bx, by, bz = (
                    _eight(x, down) * z1 - _eight(x, up) * z0, _eight(y, down) * z1 - _eight(y, up) * z0, z1 - z0,
                )  # fmt: skip
                nx, ny, nz = by * az - bz * ay, bz * ax - bx * az, bx * ay - by * ax
                length = 1.0 / ti.sqrt(nx * nx + ny * ny + nz * nz)
                # beside a hole or a step there is no normal; of NaN no comparison is true
                limit = steep * here + 3.0 * s
                da, dc = _eight(depth, g - 1), _eight(depth, g + 1)
                left, right = ti.abs(_shifted(da, here, dc, -1) - here), ti.abs(_shifted(da, here, dc, 1) - here)
                over, under = ti.abs(_eight(depth, g - across) - here), ti.abs(_eight(depth, g + across) - here)
                length = ti.select(left < limit, length, ti.math.nan)
                length = ti.select(right < limit, length, ti.math.nan)
                length = ti.select(over < limit, length, ti.math.nan)
                length = ti.select(under < limit, length, ti.math.nan)
                nx, ny, nz = nx * length, ny * length, nz * length
            for e in ti.static(range(LANES)):
                if u + e < width:
                    q = (o + e) * 3
                    points[q], points[q + 1], points[q + 2] = px[e] * here[e], py[e] * here[e], here[e]
                    normals[q], normals[q + 1], normals[q + 2] = nx[e], ny[e], nz[e]
                    sigma[o + e] = s[e] if here[e] > 0.0 else ti.math.nan
