"""What bends is flattened: windows that match, filters and wide pixels mean depth over some pixels.

A mean over a window of variance s^2 [px^2] along rows and columns adds s^2 / 2 times the Laplacian of the depth image,
the first term of its Taylor series: a box of w pixels w^2 / 24, RealSense's spatial filter about 4 px^2. What bulges
reads too far, the more the flatter it is seen, and so the axis goes to the camera or from it: by 0.35 mm on a smooth
object of 20 cm under that filter, whose size is then 0.2 % wrong. How strong it is, is one unknown beside the axis.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.turntable.model.rays import Bundle
from fusion.volume.volume import Volume

Array = NDArray[np.float64]
HALF = 3  # [px] of the window in which a surface of second order is laid: of one pixel the model's own noise is larger
SHARPEST = 1e-3  # [m/px^2] what bends more is an edge
PRIOR = 2.0  # [px^2] one standard deviation: a window of 7 px (guess)


def bends(rays: Bundle, camera: Camera, volume: Volume, T_object_camera: Array) -> NDArray[np.float32]:
    """Laplacian [m/px^2] of the depth image at each ray (m,), by the model; 0 where there is none.

    Args:
        rays: of n frames.
        camera: of the images that their pixels are in.
        volume: the model.
        T_object_camera: (n, 4, 4), NaN where a frame has no place.
    """
    found = np.zeros(len(rays.frame), np.float32)
    begins = np.searchsorted(rays.frame, np.arange(rays.n + 1))
    for k in np.flatnonzero(np.isfinite(T_object_camera).all(axis=(1, 2))):
        own = slice(begins[k], begins[k + 1])
        if own.start < own.stop:
            v, u = rays.pixels[own].T
            found[own] = laplacian(volume.raycast(camera, T_object_camera[k]).depth)[v, u]
    return found


def laplacian(depth: NDArray[np.floating]) -> NDArray[np.float32]:
    """Laplacian (h, w) [m/px^2] of a depth image [m], by least squares; 0 beside holes, edges and the border."""
    steps = np.arange(-HALF, HALF + 1, dtype=float) ** 2
    bent = 2 * (steps - steps.mean()) / np.sum((steps - steps.mean()) ** 2)
    even = np.full(len(steps), 1 / len(steps))
    known = np.isfinite(depth)
    filled = np.where(known, depth - np.median(depth[known]), 0.0) if known.any() else np.zeros(depth.shape)
    found = cv2.sepFilter2D(filled, -1, bent, even) + cv2.sepFilter2D(filled, -1, even, bent)
    whole = cv2.erode(known.astype(np.uint8), np.ones((len(steps), len(steps)), np.uint8), borderValue=0) > 0
    return np.where(whole & (np.abs(found) < SHARPEST), found, 0.0).astype(np.float32)
