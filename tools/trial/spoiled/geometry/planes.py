"""The planes of a mesh, which pixels show which, and how depth changes when a plane or the camera moves a little."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tools.trial.spoiled.folder import Array, Taken
from tools.trial.spoiled.geometry.ply import read_ply

REACH = 0.06  # [m] between a pixel's point and its plane: far above noise and effects, far below a step


@dataclass(frozen=True)
class Seen:
    """What the pixels of one moment show.

    Attributes:
        T: (4, 4) stated pose.
        which: (h, w) number of the plane, -1 where none is near.
        normal, offset: (h, w, 3) and (h, w): n . x = offset holds on the plane, NaN where none is.
        points: (h, w, 3) [m] in the world, as measured.
        rays: (h, w, 3) directions in the camera's axes, z = 1.
    """

    T: Array
    which: NDArray[np.intp]
    normal: Array
    offset: Array
    points: Array
    rays: Array

    def raised(self, height: Array) -> Array:
        """(h, w) change of z [m] when the surface stands `height` [m] along its normal; 0 where no plane is."""
        facing = (self.normal * (self.rays @ self.T[:3, :3].T)).sum(axis=-1)
        return np.nan_to_num(height / facing)

    def moved(self, T: Array) -> Array:
        """(h, w) change of z [m] when the camera is at `T` instead; 0 where no plane is."""
        return np.nan_to_num(self._depth(T) - self._depth(self.T))

    def _depth(self, T: Array) -> Array:
        facing = (self.normal * (self.rays @ T[:3, :3].T)).sum(axis=-1)
        return np.asarray((self.offset - self.normal @ T[:3, 3]) / facing)


def planes_of(mesh: bytes) -> Array:
    """(p, 4) unit normals and offsets, each plane once."""
    vertices, faces = read_ply(mesh)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    n = np.cross(b - a, c - a)
    size = np.linalg.norm(n, axis=1)
    n, a = n[size > 1e-12] / size[size > 1e-12, None], a[size > 1e-12]
    first = np.argmax(np.abs(n) > 1e-3, axis=1)
    n = n * np.sign(n[np.arange(len(n)), first])[:, None]
    both = np.column_stack([n, (n * a).sum(axis=1)])
    keep = np.unique(np.round(both, 4), axis=0, return_index=True)[1]
    return both[np.sort(keep)]


def seen(taken: Taken, frame: int = 0) -> Seen:
    """Planes by the mean of the frames of the same pose; the nearest plane to each point."""
    T, rays = taken.pose(frame), taken.rays()
    same = [i for i in range(len(taken.times)) if np.allclose(taken.pose(i), T)]
    valid = np.isfinite(taken.depth[same])
    with np.errstate(invalid="ignore"):
        z = np.where(valid, taken.depth[same], 0.0).sum(axis=0) / valid.sum(axis=0)
    points = (z[..., None] * rays) @ T[:3, :3].T + T[:3, 3]
    planes = planes_of(taken.mesh)
    away = np.abs(np.nan_to_num(points, nan=1e9) @ planes[:, :3].T - planes[:, 3])
    which = np.argmin(away, axis=-1)
    none = np.min(away, axis=-1) > REACH
    normal, offset = planes[which, :3].copy(), planes[which, 3].copy()
    normal[none], offset[none], which[none] = np.nan, np.nan, -1
    return Seen(T, which, normal, offset, points, rays)
