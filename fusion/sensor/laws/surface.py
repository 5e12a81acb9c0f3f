"""What a pixel's depth becomes when the surface behind it, or its ray, moves a little."""

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import exp
from fusion.sensor.view import Image, View

# cosine between ray and normal, times the ray's length, below which a surface is seen edge-on (87 deg)
EDGE_ON = 0.05
SMALL = 1e-3  # [rad], [m] a motion that is linear


def moved(depth: Image, displacement: NDArray[np.floating], view: View) -> Image:
    """Change (h, w) [m] of the depth when the surface moves by `displacement` (h, w, 3) or (3,) [m], camera frame.

    First order: the surface is its tangent plane, so that dz = n . D / (n . ray). 0 without normals.
    """
    if view.normals is None:
        return np.zeros((), depth.dtype)
    n, D = view.normals, displacement
    across = n[..., 0] * D[..., 0] + n[..., 1] * D[..., 1] + n[..., 2] * D[..., 2]
    return _finite(across / towards(view), depth)


def moved_rigidly(depth: Image, motion: NDArray[np.floating], view: View) -> Image:
    """Change (h, w) [m] of the depth under a small rigid motion (6,), as `geometry.pose.exp` takes it.

    First order, as `moved` with D = (R - 1) P + t, where P = depth * ray. 0 without normals.
    """
    if view.normals is None:
        return np.zeros((), depth.dtype)
    return _finite(_across(depth, motion, view) / towards(view), depth)


def rigid_motions(depth: Image, view: View) -> list[Image]:
    """Six images (h, w): what a turn of one radian about each axis [m], and a shift of a metre along it, change."""
    if view.normals is None:
        return [np.zeros((), depth.dtype)] * 6
    facing = towards(view) * depth.dtype.type(SMALL)
    return [_finite(_across(depth, SMALL * unit, view) / facing, depth) for unit in np.eye(6)]


def moved_beyond(depth: Image, motion: NDArray[np.floating], view: View) -> Image:
    """What a rigid motion (6,) of a plane changes (h, w) [m] beyond its first order, which `moved_rigidly` gives."""
    size = float(np.abs(motion).max())
    if view.normals is None or size == 0:
        return np.zeros((), depth.dtype)
    seen = seen_along(depth, view.camera.rays(), view, exp(motion))
    straight = moved_rigidly(depth, np.asarray(motion) * (SMALL / size), view) * depth.dtype.type(size / SMALL)
    return _finite(np.where(seen == depth, 0, seen - depth - straight), depth)


def seen_along(depth: Image, rays: NDArray[np.floating], view: View, T: NDArray[np.float64] | None = None) -> Image:
    """Depth (h, w) [m] of the tangent plane of each pixel along other rays (h, w, 2) x/z and y/z.

    Args:
        T: (4, 4) motion of the surface in the camera frame, before it is seen.
    """
    if view.normals is None:
        return depth
    own, other = _along(view.normals, view.camera.rays()), _along(view.normals, rays)
    shift: Image | float = 0.0
    if T is not None:
        turned = view.normals @ T[:3, :3].T.astype(view.normals.dtype)
        other = _along(turned, rays)
        shift = _dot(turned, T[:3, 3].tolist()) / depth
    with np.errstate(all="ignore"):
        ratio = (own + shift) / other
    # a ray that nearly leaves the plane says nothing about its depth
    sound = (ratio > 0.5) & (ratio < 2.0) & (np.abs(own) > EDGE_ON)
    return depth * np.where(sound, ratio, 1.0).astype(depth.dtype)


def towards(view: View) -> Image:
    """n . ray (h, w) [1] with a ray of z = 1: negative, and held away from 0, where a surface is seen edge-on."""
    assert view.normals is not None
    along = _along(view.normals, view.camera.rays())
    return np.where(np.abs(along) > EDGE_ON, along, np.copysign(np.asarray(EDGE_ON, along.dtype), along))


def _across(depth: Image, motion: NDArray[np.floating], view: View) -> Image:
    """(h, w) [m] by how much a rigid motion moves each surface along its normal."""
    assert view.normals is not None
    T, ray = exp(motion), (*np.moveaxis(view.camera.rays(), -1, 0), 1.0)
    # by coordinate and not by matrices: faster on images, and without threads that wait for each other
    n = np.moveaxis(view.normals, -1, 0)
    turned = [a * n[i] * ray[j] for (i, j), a in np.ndenumerate((T[:3, :3] - np.eye(3)).astype(depth.dtype)) if a]
    return depth * sum(turned, depth.dtype.type(0)) + _dot(view.normals, T[:3, 3].tolist())


def _along(n: Image, rays: NDArray[np.floating]) -> Image:
    return n[..., 0] * rays[..., 0] + n[..., 1] * rays[..., 1] + n[..., 2]


def _dot(n: Image, vector: list[float]) -> Image:
    x, y, z = vector
    return n[..., 0] * x + n[..., 1] * y + n[..., 2] * z


def _finite(change: Image, depth: Image) -> Image:
    return np.nan_to_num(change, copy=False, posinf=0.0, neginf=0.0).astype(depth.dtype, copy=False)
