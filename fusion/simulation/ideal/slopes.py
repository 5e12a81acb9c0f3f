"""Slopes of perfect depth: on a plane the inverse depth is linear in the ray, so its differences are the normal."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.sensor.view import Image, stretch

BENT = 0.002  # share of the inverse depth: where the slopes on both sides differ by more, one of them leads elsewhere
ROUGH = 0.01  # [rad] what rounding of the depth may turn a normal by
WIDEST = 4  # [px] that two compared pixels may be apart, however roughly the depth is rounded


def facing_of(depth: Image, camera: Camera, rounding: float = 0.0) -> tuple[Image, Image]:
    """The planes that the pixels of a perfect depth (h, w) [m] lie in.

    With w = 1 / z, a plane is w = a x + b y + c in the rays x, y, and (a, b, c) is its normal. The slopes are the mean
    of those to both neighbours; at an edge the flatter one. NaN where no neighbour is seen on a side.

    Args:
        rounding: step of the depth [m]; the rougher, the farther apart are the pixels compared.

    Returns:
        The incidence (h, w) [rad] and the normals (h, w, 3), towards the camera.
    """
    with np.errstate(all="ignore"):
        w = 1 / depth
        by = _apart(depth, camera, rounding)
        along_u, along_v = _slope(w, 1, by), _slope(w, 0, by)
        ux, uy, vx, vy = _per_ray(camera)
        a, b = along_u * ux + along_v * vx, along_u * uy + along_v * vy
        rays = camera.rays()
        c = w - a * rays[..., 0] - b * rays[..., 1]
        length = np.sqrt(a * a + b * b + c * c)
        incidence = np.arccos(np.minimum(w / (length * stretch(camera)), 1))
        normals = np.empty((*depth.shape, 3), np.float32)
        for axis, part in enumerate((a, b, c)):
            np.divide(part, -length, out=normals[..., axis])
    return incidence, normals


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
    slope = (back + forth) * np.float32(0.5 / by)
    # few pixels: at edges and at the rim
    odd = np.flatnonzero(~(np.abs(back - forth) < BENT * w))
    back, forth = back.ravel()[odd], forth.ravel()[odd]
    one = np.where(np.abs(forth) < np.abs(back), forth, back)
    slope.flat[odd] = np.where(np.isnan(one), np.fmin(back, forth), one) / np.float32(by)
    return slope


@lru_cache(maxsize=16)
def _per_ray(camera: Camera) -> tuple[NDArray | float, ...]:
    """What turns slopes per pixel (u, v) into slopes per ray (a, b): a = u ux + v vx, b = u uy + v vy."""
    if not any(camera.distortion):
        return camera.fx, 0.0, 0.0, camera.fy
    down, right = (np.asarray(np.gradient(camera.rays(), axis=axis)) for axis in (0, 1))
    # w_u = a right_x + b right_y, w_v = a down_x + b down_y
    area = right[..., 0] * down[..., 1] - right[..., 1] * down[..., 0]
    parts = (down[..., 1], -down[..., 0], -right[..., 1], right[..., 0])
    return tuple(np.ascontiguousarray(part / area, np.float32) for part in parts)
