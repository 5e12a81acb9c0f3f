"""Which points of a surface face the camera of a frame, and where in its image they lie."""

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.volume.prepared import Prepared

Array = NDArray[np.float64]

FACING = 0.1  # least cosine between normal and line of sight


def facing(
    points: NDArray[np.floating], normals: NDArray[np.floating], frame: Prepared, T: Array
) -> tuple[NDArray[np.intp], tuple[NDArray[np.intp], NDArray[np.intp]], Array]:
    """Which points (n, 3) with normals, of the object's frame, face the camera at T (4, 4) and lie in its image: (m,),
    their pixels (v, u), and their depths (m,) [m]."""
    camera, towards = frame.surface.camera, T[:3, 3] - points
    which = np.flatnonzero(np.einsum("ij,ij->i", normals, towards) > FACING * np.linalg.norm(towards, axis=1))
    here = pose.transform(pose.inverse(T), points[which].astype(float))
    u, v = np.rint(np.clip(camera.project(here), -9, 99999)).astype(int).T
    inside = (here[:, 2] > 0.05) & (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
    return which[inside], (v[inside], u[inside]), here[inside, 2]
