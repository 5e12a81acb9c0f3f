"""What a pixel's depth becomes when the surface behind it, or its ray, moves a little."""

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.view import Image, View


def moved(depth: Image, displacement: NDArray[np.floating], view: View) -> Image:
    """Change (h, w) [m] of the depth when the surface moves by `displacement` (h, w, 3) or (3,) [m], camera frame.

    First order: the surface is its tangent plane, so that dz = n . D / (n . ray). 0 without normals.
    """
    if view.normals is None:
        return np.zeros((), depth.dtype)
    normals = view.normals
    across = np.einsum("hwk,...k->hw", normals, displacement) if displacement.ndim == 1 else _dot(normals, displacement)
    return _finite(across / _towards(view), depth)


def seen_along(depth: Image, rays: NDArray[np.floating], view: View) -> Image:
    """Depth (h, w) [m] of the tangent plane of each pixel along other rays (h, w, 2) x/z and y/z."""
    if view.normals is None:
        return depth
    n = view.normals
    other = n[..., 0] * rays[..., 0] + n[..., 1] * rays[..., 1] + n[..., 2]
    with np.errstate(all="ignore"):
        ratio = _towards(view) / other
    # a ray that nearly leaves the plane says nothing about its depth
    return depth * np.where((ratio > 0.5) & (ratio < 2.0), ratio, 1.0).astype(depth.dtype)


def points(depth: Image, view: View) -> NDArray[np.floating]:
    """(h, w, 3) [m] in the camera frame."""
    return np.dstack([view.camera.rays() * depth[..., None], depth])


def _towards(view: View) -> Image:
    """n . ray (h, w), negative; held away from 0, where a surface is seen edge-on."""
    assert view.normals is not None
    rays, n = view.camera.rays(), view.normals
    along = n[..., 0] * rays[..., 0] + n[..., 1] * rays[..., 1] + n[..., 2]
    return np.where(np.abs(along) > 0.05, along, np.copysign(0.05, along))


def _dot(a: Image, b: Image) -> Image:
    return np.einsum("hwk,hwk->hw", a, b)


def _finite(change: Image, depth: Image) -> Image:
    return np.nan_to_num(change).astype(depth.dtype)
