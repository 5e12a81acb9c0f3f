# mypy: ignore-errors
"""Projection with OpenCV's lens distortion inside kernels, kept from folding back far off the axis."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.compute.language import F32, func, ti
from fusion.geometry import lanes
from fusion.geometry.camera import Camera
from fusion.geometry.lens import radial
from fusion.geometry.pose import Array

SIZE = 14  # values a kernel takes: the camera's 12 parameters, the largest radius squared, the largest gain


class Eye(NamedTuple):
    """A camera at a pose: `rows` of the pose, to or from the world as its kernel says; its `lens`; its image's size."""

    pose: F32
    camera: F32
    height: ti.i32
    width: ti.i32


@lru_cache(maxsize=16)
def lens(camera: Camera) -> NDArray[np.float32]:
    """(14,) what kernels know of a camera: fx, fy, cx, cy [px], eight distortion values, limit, gain.

    The limit is the largest (x/z)^2 + (y/z)^2 up to which the radial distortion grows: beyond it the polynomial
    turns round and would bring points from far outside back into the image. The gain is the largest stretch of an
    image distance below the limit, at least 1.
    """
    rays = camera.rays()
    radius = np.hypot(rays[..., 0], rays[..., 1])
    largest = float(np.max(radius[np.isfinite(radius)], initial=0.0)) * 1.02 + 1e-3
    r = np.linspace(0.0, largest, 2000)
    with np.errstate(all="ignore"):
        bent = r * radial(r * r, camera.distortion)
    slope = np.diff(bent) / np.diff(r)
    bad = np.flatnonzero(~(slope > 0))
    end = int(bad[0]) if len(bad) else len(slope)
    gain = max(1.0, float(slope[:end].max(initial=1.0))) * 1.1  # a tenth for the tangential part
    known = np.array([*camera.parameters, r[end] ** 2, gain], np.float32)
    known.flags.writeable = False
    return known


def eye(camera: Camera, T: Array) -> Eye:
    """A camera at a pose (4, 4) as kernels take it."""
    return Eye(rows(T), lens(camera), camera.height, camera.width)


def rows(T: Array) -> NDArray[np.float32]:
    """The upper three rows of a pose as (12,), the form kernels take."""
    return np.ascontiguousarray(T[:3], np.float32).ravel()


@func
def moved(pose: ti.template(), p: ti.template()):
    """A point (3,) at a pose given as rows."""
    return ti.Vector(
        [pose[a * 4] * p[0] + pose[a * 4 + 1] * p[1] + pose[a * 4 + 2] * p[2] + pose[a * 4 + 3]
         for a in ti.static(range(3))]
    )  # fmt: skip


@func
def load(parameters: ti.template()):
    """The 14 values as a local vector, so that they stay in registers."""
    return ti.Vector([parameters[n] for n in ti.static(range(SIZE))])


@func
def project(x: ti.template(), y: ti.template(), c: ti.template(), distorted: ti.template()):
    """Pixel (u, v) of x/z and y/z, numbers or vectors; beyond the lens' limit it lies far outside of the image."""
    u, v = lanes.project(x, y, c, distorted)
    if ti.static(distorted):
        beyond = x * x + y * y > c[12]
        u = ti.select(beyond, -1e9, u)
        v = ti.select(beyond, -1e9, v)
    return u, v


@func
def in_cone(centre: ti.template(), radius: ti.f32, c: ti.template()):
    """False when a ball [m, camera frame] lies outside of the cone around all that the camera sees."""
    rim = ti.sqrt(c[12])
    aside = ti.sqrt(centre[0] * centre[0] + centre[1] * centre[1])
    return centre[2] + radius > 0.0 and aside - rim * centre[2] < radius * ti.sqrt(1.0 + c[12])
