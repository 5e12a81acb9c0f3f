"""A view estimated from a measurement: what can be known of a surface from its depth image alone."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.sensor.moment import Moment
from fusion.sensor.view import BASELINE_M, Image, View, incidence_of


def estimated_view(
    depth: Image,
    camera: Camera,
    ir: NDArray | None = None,
    moment: Moment | None = None,
    baseline: float = BASELINE_M,
) -> View:
    """The view of a measured depth image (h, w) [m]: normals by central differences of its points.

    Normals and incidence are NaN where a neighbour is missing, and rough where the depth is noisy.
    """
    points = camera.points(depth)
    normals = np.full(points.shape, np.nan, np.float32)
    with np.errstate(all="ignore"):
        along_u = points[1:-1, 2:] - points[1:-1, :-2]
        along_v = points[2:, 1:-1] - points[:-2, 1:-1]
        normal = np.cross(along_v, along_u)
        normals[1:-1, 1:-1] = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
        view = View(camera, depth, incidence_of(normals, camera), normals, ir=ir, baseline=baseline)
    return view if moment is None else replace(view, moment=moment)
