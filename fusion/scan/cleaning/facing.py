"""Which points of a surface face a camera, and where in its image they lie."""

import numpy as np
from numpy.typing import NDArray

from fusion.compute.start import start
from fusion.geometry.camera import Camera
from fusion.geometry.lens import beyond

Array = NDArray[np.float64]

FACING = 0.1  # least cosine between normal and line of sight


def facing(
    points: NDArray[np.floating], normals: NDArray[np.floating], camera: Camera, poses: Array
) -> tuple[NDArray[np.int32], Array, Array]:
    """Which points (n, 3) with normals, of the object's frame, face a camera at poses (k, 4, 4) and lie in its image:
    their pixels (k, n) counted along the rows, -1 for other points; depths (k, n) [m] and cosines (k, n), 0 there."""
    from fusion.scan.cleaning.facing_kernel import COSINE, DEPTH, TANGENT, place_points  # starts Taichi

    start()
    stands = np.ascontiguousarray(np.concatenate([poses[:, :3, :3].swapaxes(1, 2), poses[:, None, :3, 3]], axis=1))
    place = np.empty((len(poses), len(points)), np.int32)
    seen = np.empty((*place.shape, 3))
    place_points(
        np.ascontiguousarray(points, float), np.ascontiguousarray(normals, np.float32),
        stands, camera.parameters.astype(float), np.array(camera.shape, np.int32), FACING, place, seen,
    )  # fmt: skip
    if any(camera.distortion):
        tangent = seen[..., TANGENT]
        place[beyond(tangent, np.zeros_like(tangent), camera.distortion)] = -1
    return place, seen[..., DEPTH], seen[..., COSINE]
