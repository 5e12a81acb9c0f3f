"""View: what every pixel looked at, as far as sensor effects ask for it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera

Image = NDArray[np.floating]

# Kinect v1: Pagliari 2014 states about 7.4 cm, github ankurhanda/simkinect uses 0.075
BASELINE_M = 0.075


@dataclass(frozen=True)
class View:
    """What the pixels of one frame looked at: from the renderer (truth), or estimated from a measurement.

    Attributes:
        camera: the depth camera.
        depth: (h, w) planar z [m] of the surface, NaN where there is none.
        incidence: (h, w) angle between ray and surface normal [rad], 0 frontal; None when not known.
        normals: (h, w, 3) unit normals in the camera frame, towards the camera; None when not known.
        ir: (h, w) amplitude [count]; None when not known.
        color: (h, w, 3) uint8 RGB; None when not known.
        baseline: projector to camera [m], for triangulating sensors.
    """

    camera: Camera
    depth: Image | None = None
    incidence: Image | None = None
    normals: Image | None = None
    ir: NDArray | None = None
    color: NDArray[np.uint8] | None = None
    baseline: float = BASELINE_M

    @property
    def focal_baseline(self) -> float:
        """Disparity times depth [px m]."""
        return self.camera.fx * self.baseline

    @property
    def stretch(self) -> NDArray[np.float32]:
        """(h, w) length of the ray per metre of depth [1]: radial distance = stretch * z."""
        return np.sqrt(1.0 + (self.camera.rays() ** 2).sum(axis=-1))

    @property
    def u(self) -> NDArray[np.float64]:
        """(1, w) column of a pixel [px]."""
        return np.arange(self.camera.width, dtype=float)[None, :]

    @property
    def v(self) -> NDArray[np.float64]:
        """(h, 1) row of a pixel [px]."""
        return np.arange(self.camera.height, dtype=float)[:, None]

    @property
    def radius(self) -> NDArray[np.float64]:
        """(h, w) distance to the principal point [px]."""
        return np.hypot(self.u - self.camera.cx, self.v - self.camera.cy)


def estimated_view(depth: Image, camera: Camera, baseline: float = BASELINE_M) -> View:
    """A view estimated from a measured depth image (h, w) [m]: normals by central differences of its points.

    Normals and incidence are NaN where a neighbour is missing, and rough where the depth is noisy.
    """
    points = camera.points(depth)
    normals = np.full(points.shape, np.nan, np.float32)
    with np.errstate(all="ignore"):
        along_u = points[1:-1, 2:] - points[1:-1, :-2]
        along_v = points[2:, 1:-1] - points[:-2, 1:-1]
        normal = np.cross(along_v, along_u)
        normals[1:-1, 1:-1] = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
        return View(camera, depth, incidence_of(normals, camera), normals, baseline=baseline)


def incidence_of(normals: Image, camera: Camera) -> Image:
    """Angle (h, w) [rad] between the pixels' rays and the normals (h, w, 3) in the camera frame."""
    rays = camera.rays()
    along = normals[..., 0] * rays[..., 0] + normals[..., 1] * rays[..., 1] + normals[..., 2]
    length = np.sqrt(1.0 + (rays**2).sum(axis=-1))
    return np.arccos(np.clip(np.abs(along) / length, 0.0, 1.0))
