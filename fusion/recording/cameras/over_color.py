"""Depth as the colour camera beside it would see it: for formats in which depth lies over colour."""

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, inverse, transform
from fusion.recording.cameras.own_cameras import RIM

STEPS = 4  # each leaves a share of the error as large as the cameras' distance over the depth's: a tenth or less
NOWHERE = float("nan")


def fine_as(color: Camera, depth: Camera) -> Camera:
    """The colour camera with pixels no finer than the depth camera's: more would be made up."""
    share = min(1.0, depth.fx / color.fx, depth.fy / color.fy)
    return color.resized(max(1, round(share * color.width)), max(1, round(share * color.height)))


def depth_over(
    depth: NDArray[np.float32], camera: Camera, seen_by: Camera, T_seen_camera: Array
) -> NDArray[np.float32]:
    """Depth (h, w) [m] in the pixels of another camera; NaN where it sees nothing, or what the first one did not.

    Args:
        depth: (height, width) [m], NaN where missing.
        camera: took it.
        seen_by: the other one.
        T_seen_camera: (4, 4) maps points of `camera` to `seen_by`.
    """
    first = _nearest(depth, camera, seen_by, T_seen_camera)
    rays = np.dstack([seen_by.rays().astype(float), np.ones(seen_by.shape)])
    back, there = inverse(T_seen_camera), first.astype(float)
    with np.errstate(invalid="ignore", divide="ignore"):
        for _ in range(STEPS):
            points = transform(back, (rays * there[..., None]).reshape(-1, 3))
            at = _sampled(depth, camera.project(points).reshape(*seen_by.shape, 2).astype(np.float32))
            found = points * (at.ravel() / points[:, 2])[:, None]
            there = transform(T_seen_camera, found)[:, 2].reshape(seen_by.shape)
        same = np.abs(there - first) <= 2 * RIM * first  # else it slid behind what stands in front
    return np.where(same, there, NOWHERE).astype(np.float32)


def _nearest(depth: NDArray[np.float32], camera: Camera, seen_by: Camera, T: Array) -> NDArray[np.float32]:
    """What the other camera sees, to a pixel: the nearest point of each, and of its neighbours where it has none."""
    points = camera.points(depth).reshape(-1, 3).astype(float)
    points = transform(T, points[np.isfinite(points[:, 2])])
    points = points[points[:, 2] > 0]
    points = points[np.argsort(-points[:, 2])]  # of those in one pixel the last one stays
    with np.errstate(invalid="ignore"):
        pixels = np.rint(seen_by.project(points))
        inside = ((pixels >= 0) & (pixels < [seen_by.width, seen_by.height])).all(axis=1)
    u, v = pixels[inside].astype(int).T
    found = np.full(seen_by.shape, np.float32(np.inf))
    found[v, u] = points[inside, 2]
    around = cv2.erode(found, np.ones((3, 3), np.uint8), borderType=cv2.BORDER_REPLICATE)
    seen = np.where(np.isfinite(found), found, around)
    return np.where(np.isfinite(seen), seen, np.float32(NOWHERE))


def _sampled(depth: NDArray[np.float32], pixels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Depth between pixels: 1 / depth goes on evenly, as over a plane; at rims the nearest pixel counts."""
    u, v = pixels[..., 0], pixels[..., 1]
    nearest = cv2.remap(depth, u, v, cv2.INTER_NEAREST, borderMode=cv2.BORDER_CONSTANT, borderValue=NOWHERE)
    even = 1 / cv2.remap(1 / depth, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=NOWHERE)
    return np.where(np.abs(even - nearest) <= RIM * nearest, even, nearest).astype(np.float32)
