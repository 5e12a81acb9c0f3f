"""Depth images: smoothing, edges, points with normals, half resolution. Missing is NaN."""

from dataclasses import dataclass

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
    missing = ~np.isfinite(depth)
    # a far-away value gets no range weight, so missing pixels do not leak into their neighbours
    filled = np.where(missing, np.float32(-1e3), depth).astype(np.float32)
    out = cv2.bilateralFilter(filled, 2 * radius + 1, step, radius / 1.5)
    out[missing] = np.nan
    return np.asarray(out, np.float32)


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


def normals(points: Image, reach: int = 2) -> Image:
    """Normals (h, w, 3) of an organised point image (h, w, 3), by differences over +-`reach` px; NaN at holes."""
    du = np.full_like(points, np.nan)
    dv = np.full_like(points, np.nan)
    du[:, reach:-reach] = points[:, 2 * reach :] - points[:, : -2 * reach]
    dv[reach:-reach] = points[2 * reach :] - points[: -2 * reach]
    out = np.cross(dv, du)
    out /= np.maximum(np.linalg.norm(out, axis=2, keepdims=True), 1e-20)
    return np.asarray(np.where(np.einsum("vuk,vuk->vu", out, points)[..., None] > 0, -out, out), np.float32)


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
    step = 6 * float(np.nanmedian(spread)) if np.isfinite(spread).any() else 0.01
    points = camera.points(depth)
    found = normals(camera.points(smooth(depth, step, radius)))
    # a surface seen at 80 degrees changes its depth by 5.7 pixel widths from one pixel to the next
    found[edges(depth, 5.7 * depth / camera.fx + 3 * spread, border)] = np.nan
    return PointMap(camera, points, found, np.where(np.isfinite(depth), spread, np.nan).astype(np.float32))
