"""Slopes of perfect depth: on a plane the inverse depth is linear in the ray, so its differences are the normal."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.sensor.view import Image, stretch

BENT = 0.002  # share of the inverse depth: where the slopes on both sides differ by more, one of them leads elsewhere
# Abramowitz and Stegun 4.4.46, over sqrt(1 - x)
ARC_COSINE = (1.5707963050, -0.2145988016, 0.0889789874, -0.0501743046, 0.0308918810, -0.0170881256, 0.0066700901,
              -0.0012624911)  # fmt: skip
ROUGH = 0.01  # [rad] what rounding of the depth may turn a normal by
WIDEST = 4  # [px] that two compared pixels may be apart, however roughly the depth is rounded


@dataclass(frozen=True)
class Facing:
    """How the pixels' surfaces lie to the camera."""

    incidence: Image  # (h, w) angle of ray and normal [rad]
    cosine: Image  # (h, w) of it
    normals: Image | None  # (h, w, 3) unit normals, towards the camera; None where nobody asked


def facing_of(depth: Image, camera: Camera, rounding: float = 0.0, normals: bool = True) -> Facing:
    """The planes that the pixels of a perfect depth (h, w) [m] lie in.

    With w = 1 / z, a plane is w = a x + b y + c in the rays x, y, and (a, b, c) is its normal. The slopes are the mean
    of those to both neighbours; at an edge the flatter one. NaN where no neighbour is seen on a side.

    Args:
        rounding: step of the depth [m]; the rougher, the farther apart are the pixels compared.
        normals: wanted too.
    """
    depth = np.asarray(depth, np.float32)
    x, y = _planes(camera)
    with np.errstate(all="ignore"):
        w = 1 / depth
        by = _apart(depth, camera, rounding)
        a, b = _per_ray(_slope(w, 1, by), _slope(w, 0, by), camera)
        c, part = w - a * x, b * y
        c -= part
        length = a * a
        length += np.multiply(b, b, out=part)
        length += np.multiply(c, c, out=part)
        np.sqrt(length, out=length)
        cosine = np.divide(w, np.multiply(length, stretch(camera), out=part), out=part)
        np.minimum(cosine, 1, out=cosine)
        towards = None
        if normals:
            towards = np.empty((*depth.shape, 3), np.float32)
            np.negative(length, out=length)
            for axis, along in enumerate((a, b, c)):
                np.divide(along, length, out=towards[..., axis])
        return Facing(arc_cosine(cosine), cosine, towards)


def arc_cosine(cosine: Image) -> Image:
    """The angle [rad] of a cosine from 0 to 1, to 1e-7: a fifth of the time of numpy's."""
    *others, last = ARC_COSINE
    curve = np.full_like(cosine, last)
    for factor in reversed(others):
        curve *= cosine
        curve += factor
    left = 1 - cosine
    curve *= np.sqrt(left, out=left)
    return curve


@lru_cache(maxsize=16)
def _planes(camera: Camera) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """x/z and y/z of the rays, as images of their own: (h, w), or (1, w) and (h, 1) where no lens bends them."""
    x, y = (np.ascontiguousarray(camera.rays()[..., axis]) for axis in (0, 1))
    return (x, y) if any(camera.distortion) else (x[:1], y[:, :1])


def _apart(depth: Image, camera: Camera, rounding: float) -> int:
    """How many pixels apart the compared ones are: on a slope, rounding is even over the step."""
    if not rounding or not np.isfinite(depth).any():
        return 1
    pixel = float(np.nanmedian(depth[::8, ::8])) / max(camera.fx, camera.fy)  # [m]
    spread = rounding * np.sqrt(2 / 12)  # of a difference of two rounded values
    return int(np.clip(np.ceil(spread / (2 * pixel * ROUGH)), 1, WIDEST)) if pixel > 0 else 1


def _slope(w: Image, axis: int, by: int) -> Image:
    """Change of the inverse depth per pixel along an axis."""
    step = np.full((w.shape[0] + by, w.shape[1]) if axis == 0 else (w.shape[0], w.shape[1] + by), np.nan, w.dtype)
    # from pixel i - by to pixel i
    after = np.s_[by:] if axis == 0 else np.s_[:, by:]
    inner = np.s_[by:-by] if axis == 0 else np.s_[:, by:-by]
    if min(step[inner].shape) < 1:
        return np.full(w.shape, np.nan, w.dtype)
    step[inner] = w[after] - (w[: len(w) - by] if axis == 0 else w[:, : w.shape[1] - by])
    back = step[: len(w)] if axis == 0 else step[:, : w.shape[1]]
    forth = step[by:] if axis == 0 else step[:, by:]
    slope = back - forth
    # few pixels: at edges and at the rim
    odd = np.flatnonzero(~(np.abs(slope, out=slope) < BENT * w))
    np.add(back, forth, out=slope)
    slope *= np.float32(0.5 / by)
    back, forth = back.ravel()[odd], forth.ravel()[odd]
    one = np.where(np.abs(forth) < np.abs(back), forth, back)
    slope.flat[odd] = np.where(np.isnan(one), np.fmin(back, forth), one) / np.float32(by)
    return slope


def _per_ray(along_u: Image, along_v: Image, camera: Camera) -> tuple[Image, Image]:
    """Slopes per ray (a, b) from slopes per pixel (u, v), which are overwritten."""
    if not any(camera.distortion):
        along_u *= np.float32(camera.fx)
        along_v *= np.float32(camera.fy)
        return along_u, along_v
    ux, uy, vx, vy = _bending(camera)
    return along_u * ux + along_v * vx, along_u * uy + along_v * vy


@lru_cache(maxsize=16)
def _bending(camera: Camera) -> tuple[NDArray[np.float32], ...]:
    """What turns slopes per pixel into slopes per ray behind a lens: a = u ux + v vx, b = u uy + v vy."""
    down, right = (np.asarray(np.gradient(camera.rays(), axis=axis)) for axis in (0, 1))
    # w_u = a right_x + b right_y, w_v = a down_x + b down_y
    area = right[..., 0] * down[..., 1] - right[..., 1] * down[..., 0]
    parts = (down[..., 1], -down[..., 0], -right[..., 1], right[..., 0])
    return tuple(np.ascontiguousarray(part / area, np.float32) for part in parts)
