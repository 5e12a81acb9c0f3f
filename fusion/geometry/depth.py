"""Depth images as points with normals. Missing is NaN."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera

Image = NDArray[np.float32]


@dataclass(frozen=True)
class PointMap:
    """What a depth image says about the surface, in camera coordinates."""

    camera: Camera  # the camera whose pixels these are
    points: Image  # (h, w, 3) [m], NaN where missing
    normals: Image  # (h, w, 3) unit vectors towards the camera, NaN where unknown
    sigma: Image  # (h, w) standard deviation of the depth [m]; NaN where missing
    # (h, w) angle between the line of sight and the normal [rad], NaN where that is unknown; None for what a model
    # shows
    incidence: Image | None = None


def point_map(depth: Image, camera: Camera, sigma: Image | float = 0.002) -> PointMap:
    """Points, normals and spread of a depth image (h, w) [m].

    The points are the unfiltered depth; only the normals come from a smoothed copy. Pixels beside a hole or a step get
    no normal, so they take no part in alignment.

    Args:
        depth: (h, w) [m], NaN where missing.
        sigma: (h, w) or one standard deviation of the depth [m].
    """
    from fusion.geometry.relief import relief  # Taichi starts with the first image

    spread = np.ascontiguousarray(np.broadcast_to(np.asarray(sigma, np.float32), depth.shape))
    some = spread[:1, :1] if np.ndim(sigma) == 0 else spread[::4, ::4]
    some = some[np.isfinite(some)]
    step = max(6 * float(np.median(some)), 1e-4) if len(some) else 0.01
    points, normals, incidence = relief(depth, camera, spread, step)
    with np.errstate(invalid="ignore"):  # an infinite depth is missing too
        return PointMap(camera, points, normals, spread + 0 * depth, incidence)
