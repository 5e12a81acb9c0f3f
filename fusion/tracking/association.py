# mypy: ignore-errors
"""Projective association on Taichi: which model point does each source point fall on?

The kernels see a camera as (12,) parameters: fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6 (OpenCV's order).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.compute.arrays import F32, F32_2, F32_3, I32
from fusion.compute.language import kernel, ti
from fusion.compute.start import start
from fusion.geometry.depth import PointMap
from fusion.geometry.lanes import project

vec3 = ti.types.vector(3, ti.f32)


class Model(NamedTuple):
    """What is met: points and normals (h, w, 3), and the camera (12,)."""

    points: F32_3
    normals: F32_3
    camera: F32


@kernel
def _associate(
    points: F32_2,  # (n, 3) source points
    normals: F32_2,  # (n, 3) source normals, may be NaN
    T: F32_2,  # (4, 4) model from source
    model: Model,
    reach: ti.f32,  # largest distance of a pair [m]
    min_cosine: ti.f32,  # smallest cosine between normals
    pixel: I32,  # (n,) out: v * w + u, or a code below 0
    moved: F32_2,  # (n, 3) out: source points in the model's camera
):
    """Finds what each point meets."""
    h = model.points.shape[0]
    w = model.points.shape[1]
    for i in range(points.shape[0]):
        p = vec3(points[i, 0], points[i, 1], points[i, 2])
        n = vec3(normals[i, 0], normals[i, 1], normals[i, 2])
        q = vec3(0.0)
        m = vec3(0.0)
        for r in ti.static(range(3)):
            q[r] = T[r, 0] * p[0] + T[r, 1] * p[1] + T[r, 2] * p[2] + T[r, 3]
            m[r] = T[r, 0] * n[0] + T[r, 1] * n[1] + T[r, 2] * n[2]
            moved[i, r] = q[r]
        code = OUTSIDE
        if q[2] > 0.05:
            x, y = project(q[0] / q[2], q[1] / q[2], model.camera, True)
            u = ti.floor(x + 0.5, ti.i32)
            v = ti.floor(y + 0.5, ti.i32)
            if 0 <= u < w and 0 <= v < h:
                z = model.points[v, u, 2]
                if not z > 0.0:
                    code = UNKNOWN
                else:
                    d = q - vec3(model.points[v, u, 0], model.points[v, u, 1], z)
                    if q[2] < z - reach:
                        code = IN_FRONT
                    elif d.norm() < reach:
                        nm = vec3(model.normals[v, u, 0], model.normals[v, u, 1], model.normals[v, u, 2])
                        code = NO_NORMAL
                        if nm.norm() > 0.5:  # NaN compares false
                            code = FACING_AWAY
                            if m.dot(nm) > min_cosine:
                                code = v * w + u
                    else:
                        code = BEHIND
        pixel[i] = code


# why a source point has no partner
OUTSIDE, UNKNOWN, IN_FRONT, BEHIND, NO_NORMAL, FACING_AWAY = -1, -2, -3, -4, -5, -6


def associate(
    points: NDArray[np.float32],
    normals: NDArray[np.float32],
    T_model_source: NDArray[np.float64],
    model: PointMap,
    reach: float,
    min_cosine: float = 0.7,
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Find the model pixel under each source point.

    Args:
        points, normals: (n, 3) of the source, in its own camera.
        T_model_source: (4, 4).
        model: points and normals to be met.
        reach: largest distance of a pair [m].
        min_cosine: smallest cosine between the normals of a pair.

    Returns:
        pixel (n,) int32: flat index into the model's image, or one of OUTSIDE (the image), UNKNOWN (no model there),
        IN_FRONT (of the model: the model's camera would have seen it), BEHIND, NO_NORMAL, FACING_AWAY;
        moved (n, 3): the points in the model's camera [m].
    """
    start()
    pixel = np.empty(len(points), np.int32)
    moved = np.empty((len(points), 3), np.float32)
    if len(points):
        _associate(
            np.ascontiguousarray(points, np.float32),
            np.ascontiguousarray(normals, np.float32),
            np.ascontiguousarray(T_model_source, np.float32),
            Model(np.ascontiguousarray(model.points), np.ascontiguousarray(model.normals), model.camera.parameters),
            reach,
            min_cosine,
            pixel,
            moved,
        )
    return pixel, moved
