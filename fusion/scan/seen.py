"""Which parts of a surface any frame shows: where frames lie beside each other, a volume grows walls that none saw."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.mesh.mesh import Mesh
from fusion.volume.prepared import Prepared

Array = NDArray[np.float64]
FACING = 0.1  # least cosine between normal and line of sight


def seen_by_any(mesh: Mesh, frames: Sequence[Prepared | None], poses: Array, near: float) -> NDArray[np.bool_]:
    """(n,) bool: vertices that face the camera of some frame, at the depth that it measured.

    Args:
        mesh: with normals.
        frames: k of them.
        poses: (k, 4, 4) `T_object_camera`, NaN where a frame has none.
        near: largest difference in depth [m].
    """
    assert mesh.normals is not None
    found = np.zeros(len(mesh.vertices), bool)
    for frame, T in zip(frames, poses, strict=True):
        left = np.flatnonzero(~found)
        if frame is None or not np.isfinite(T).all() or not len(left):
            continue
        camera = frame.surface.camera
        towards = T[:3, 3] - mesh.vertices[left]
        facing = np.einsum("ij,ij->i", mesh.normals[left], towards) > FACING * np.linalg.norm(towards, axis=1)
        left = left[facing]
        points = pose.transform(pose.inverse(T), mesh.vertices[left].astype(float))
        u, v = np.rint(np.clip(camera.project(points), -9, 99999)).astype(int).T
        inside = (points[:, 2] > 0.05) & (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
        left, points, u, v = left[inside], points[inside], u[inside], v[inside]
        found[left[np.abs(frame.depth[v, u] - points[:, 2]) < near]] = True  # of NaN it is not true
    return found
