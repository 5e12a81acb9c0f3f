"""Depth images: smoothing, edges, points with normals, half resolution. Missing is NaN."""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera

Image = NDArray[np.float32]


@dataclass(frozen=True)
class PointMap:
    """What a depth image says about the surface, in camera coordinates.

    Attributes:
        camera: the camera whose pixels these are.
        points: (h, w, 3) [m], NaN where missing.
        normals: (h, w, 3) unit vectors towards the camera, NaN where unknown.
        sigma: (h, w) standard deviation of the depth [m]; NaN where missing.
    """

    camera: Camera
    points: Image
    normals: Image
    sigma: Image

    @property
    def incidence(self) -> Image:
        """(h, w) angle between the line of sight and the normal [rad]."""
        return incidence(self.points, self.normals)


def incidence(points: Image, normals: Image) -> Image:
    """Angle (h, w) between lines of sight to points (h, w, 3) [m] and normals (h, w, 3) [rad]."""
    cosine = -np.einsum("vuk,vuk->vu", points, normals) / np.linalg.norm(points, axis=2)
    return np.arccos(np.clip(cosine, -1, 1)).astype(np.float32)


def smooth(depth: Image, step: float, radius: int = 4) -> Image:
    """Bilateral filter of a depth image (h, w) [m]: averages within `radius` px, not across steps above `step`."""
    out = np.full(depth.shape, np.nan, np.float32)
    known = np.isfinite(depth)
    rows, columns = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
    if len(rows):  # an object fills a small part of its images
        box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
        # a far-away value gets no range weight, so missing pixels do not leak into their neighbours
        filled = np.where(known[box], depth[box], np.float32(-1e3)).astype(np.float32)
        filtered = cv2.bilateralFilter(filled, 2 * radius + 1, step, radius / 1.5)
        np.copyto(out[box], filtered, where=known[box])
    return out


def edges(depth: Image, jump: Image | float, width: int = 1) -> NDArray[np.bool_]:
    """Pixels (h, w) within `width` px of a hole, or of a step between neighbours larger than `jump` [m]."""
    near = np.where(np.isfinite(depth), depth, np.float32(0))
    limit = np.broadcast_to(np.asarray(jump, np.float32), depth.shape)
    torn = ~np.isfinite(depth)
    for axis in (0, 1):
        step = np.abs(np.diff(near, axis=axis)) > np.delete(limit, 0, axis)
        torn |= np.insert(step, 0, False, axis=axis) | np.insert(step, step.shape[axis], False, axis=axis)
    kernel = np.ones((2 * width - 1, 2 * width - 1), np.uint8)
    return np.asarray(cv2.dilate(torn.astype(np.uint8), kernel) > 0)


def normals(depth: Image, camera: Camera, reach: int = 2) -> Image:
    """Normals (h, w, 3) towards the camera of a depth image (h, w) [m], by differences over +-`reach` px; NaN at holes.

    On the plane a X + b Y + c Z = 1 the inverse depth is a x + b y + c along the ray (x, y, 1): its differences over
    those of the rays give a and b, whatever the plane's slant, and (a, b, c) is the normal.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return _normals(depth, camera, reach)


def _normals(depth: Image, camera: Camera, reach: int) -> Image:
    xu, yu, xv, yv = _steps(camera, reach)
    inverse = np.float32(1) / depth
    du, dv = np.full_like(depth, np.nan), np.full_like(depth, np.nan)
    np.subtract(inverse[:, 2 * reach :], inverse[:, : -2 * reach], out=du[:, reach:-reach])
    np.subtract(inverse[2 * reach :], inverse[: -2 * reach], out=dv[reach:-reach])
    rays = camera.rays()
    if any(camera.distortion):
        across = xu * yv - xv * yu
        a, b = (du * yv - dv * yu) / across, (dv * xu - du * xv) / across
    else:
        a, b = du / xu, dv / yv
    c = inverse - rays[..., 0] * a - rays[..., 1] * b
    length = np.float32(-1) / np.sqrt(a * a + b * b + c * c)
    out = np.empty((*depth.shape, 3), np.float32)
    for axis, part in enumerate((a, b, c)):
        np.multiply(part, length, out=out[..., axis])
    return out


@lru_cache(maxsize=8)
def _steps(camera: Camera, reach: int) -> tuple[Image | np.float32, ...]:
    """Differences of the rays' x and y along u, then along v, from `reach` px before a pixel to `reach` px after it;
    single numbers without lens distortion."""
    if not any(camera.distortion):
        zero = np.float32(0)
        return np.float32(2 * reach / camera.fx), zero, zero, np.float32(2 * reach / camera.fy)
    rays = camera.rays()
    out = [np.full(camera.shape, np.nan, np.float32) for _ in range(4)]
    for axis in range(2):
        out[axis][:, reach:-reach] = rays[:, 2 * reach :, axis] - rays[:, : -2 * reach, axis]
        out[2 + axis][reach:-reach] = rays[2 * reach :, :, axis] - rays[: -2 * reach, :, axis]
    return tuple(out)


def point_map(depth: Image, camera: Camera, sigma: Image | float = 0.002, radius: int = 4, border: int = 1) -> PointMap:
    """Points, normals and spread of a depth image (h, w) [m].

    The points are the unfiltered depth; only the normals come from a smoothed copy.

    Args:
        depth: (h, w) [m], NaN where missing.
        camera: its camera.
        sigma: (h, w) or one standard deviation of the depth [m].
        radius: of the smoothing for the normals [px].
        border: pixels this close to a depth step get no normal, so they take no part in alignment [px].
    """
    spread = np.broadcast_to(np.asarray(sigma, np.float32), depth.shape).astype(np.float32)
    some = spread[:1, :1] if np.ndim(sigma) == 0 else spread[::4, ::4]
    some = some[np.isfinite(some)]
    step = 6 * float(np.median(some)) if len(some) else 0.01
    points = camera.points(depth)
    found = normals(smooth(depth, step, radius), camera)
    # a surface seen at 80 degrees changes its depth by 5.7 pixel widths from one pixel to the next
    known = np.isfinite(depth)
    found[edges(depth, 5.7 * depth / camera.fx + 3 * spread, border) & known] = np.nan
    return PointMap(camera, points, found, np.where(known, spread, np.float32(np.nan)))
