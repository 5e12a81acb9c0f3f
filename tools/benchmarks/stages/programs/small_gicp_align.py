# mypy: ignore-errors
"""small_gicp, point to plane, two threads; its stop thresholds are looser."""

import numpy as np
import small_gicp
from common import load, measure_align

w = load()
v, u = np.mgrid[0:480, 0:640]
x, y = (u - w.K[0, 2]) / w.K[0, 0], (v - w.K[1, 2]) / w.K[1, 1]


def cloud(k: int):
    z = w.depth[k] * 1e-3
    points = np.stack([x * z, y * z, z], axis=-1)[z > 0]
    return small_gicp.preprocess_points(points, downsampling_resolution=w.voxel / 4, num_neighbors=20, num_threads=2)


def place(source: int, target: int) -> np.ndarray:
    (model, tree), (points, _) = cloud(target), cloud(source)
    return small_gicp.align(
        model, points, tree, np.eye(4), registration_type="PLANE_ICP",
        max_correspondence_distance=2.5 * w.truncation, num_threads=2, max_iterations=20,
    ).T_target_source  # fmt: skip


measure_align(place, w)
