# mypy: ignore-errors
"""Open3D's multi-scale point-to-plane odometry: fast, and the least accurate."""

import numpy as np
import open3d as o3d
from common import load, measure_align

w = load()
pipeline = o3d.t.pipelines.odometry
grey = o3d.t.geometry.Image(o3d.core.Tensor(np.zeros((480, 640, 3), np.uint8)))
images = [o3d.t.geometry.RGBDImage(grey, o3d.t.geometry.Image(o3d.core.Tensor(d))) for d in w.depth]
K, still = o3d.core.Tensor(w.K), o3d.core.Tensor(np.eye(4))
steps = [pipeline.OdometryConvergenceCriteria(n) for n in (10, 5, 4)]


def place(source: int, target: int) -> np.ndarray:
    found = pipeline.rgbd_odometry_multi_scale(
        images[source], images[target], K, still, 1000.0, w.far, steps, pipeline.Method.PointToPlane
    )
    return found.transformation.numpy()


measure_align(place, w)
