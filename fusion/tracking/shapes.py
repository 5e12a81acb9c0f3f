"""Landmarks of bare surfaces, for recordings without colour: points whose surroundings are bent as few others are.

Fast point feature histograms (Rusu, Blodow and Beetz 2009) by Open3D; of all points those are kept whose histogram is
farthest from the mean, as the persistent ones there (sec. III).
"""

import importlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.tracking.landmarks import Landmarks

Array = NDArray[np.float64]

GRAIN = 0.03  # of the distance: one point in each such cell [1]
AROUND = 5.0  # cells around a point that its histogram sums up
NEIGHBOURS = 80  # of them at most
MOST = 700  # landmarks
FEWEST = 200  # points that have any


def shape_landmarks(points: Array, normals: Array) -> Landmarks:
    """Landmarks of points (n, 3) [m] with normals (n, 3), seen from about the origin."""
    o3d: Any = importlib.import_module("open3d")  # its type stubs reject what it takes
    cell = GRAIN * float(np.median(np.linalg.norm(points, axis=1))) if len(points) else 1.0
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    cloud.normals = o3d.utility.Vector3dVector(normals)
    cloud = cloud.voxel_down_sample(cell)
    kept = np.asarray(cloud.points)
    if len(kept) < FEWEST:
        return Landmarks(np.zeros((0, 3)), np.zeros(0), np.zeros((0, 33), np.float32))
    search = o3d.geometry.KDTreeSearchParamHybrid(AROUND * cell, NEIGHBOURS)
    histograms = np.asarray(o3d.pipelines.registration.compute_fpfh_feature(cloud, search).data).T
    unlike = np.linalg.norm(histograms - histograms.mean(axis=0), axis=1)
    best = np.argsort(-unlike, kind="stable")[:MOST]
    return Landmarks(kept[best], np.full(len(best), cell / 2), histograms[best].astype(np.float32))
