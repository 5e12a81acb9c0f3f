"""A mesh made ready to be looked at from many places."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array
from fusion.mesh.comparison.surface_samples import vertex_normals
from fusion.mesh.mesh import Mesh


class RayMesh:
    """A mesh in a search tree for rays.

    Attributes:
        centre: (3,) [m]; coordinates count from here, so that single precision is exact enough.
        vertices: (3, n) from the centre [m], the points that are asked for; coordinates lie in rows, as they are
            worked on one by one.
        normals: (3, n) outward unit normals.
    """

    def __init__(self, mesh: Mesh, at: Mesh | None = None) -> None:
        """Triangles that hide each other, and the points on them that are asked for: their vertices, or those `at`."""
        import open3d as o3d

        asked = mesh if at is None else at

        self.centre = (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0)) / 2
        local = (mesh.vertices - self.centre).astype(np.float32)
        normals = asked.normals if asked.normals is not None else vertex_normals(asked)
        self.vertices = np.ascontiguousarray((asked.vertices - self.centre).T, np.float32)
        self.normals = np.ascontiguousarray(normals.T, np.float32)
        self._tensor = o3d.core.Tensor.from_numpy
        self._scene = o3d.t.geometry.RaycastingScene()
        faces = np.ascontiguousarray(mesh.faces, np.uint32)
        self._scene.add_triangles(self._tensor(local), self._tensor(faces))

    def seen_by(self, camera: Camera, T_world_camera: Array) -> NDArray[np.int64]:
        """Vertices (k,) that lie about within the picture: beyond it lens models may fold back."""
        x, y, z = self._along(self.vertices, T_world_camera)
        wide, high = _reach(camera)
        return np.flatnonzero((z > 1e-3) & (np.abs(x) < wide * z) & (np.abs(y) < high * z))

    def points(self, index: NDArray[np.int64], T_world_camera: Array) -> NDArray[np.float32]:
        """Vertices `index` (k,) as points (3, k) in a camera's frame [m]."""
        return np.stack(self._along(self.vertices[:, index], T_world_camera))

    def cosine(self, index: NDArray[np.int64], T_world_camera: Array) -> NDArray[np.float32]:
        """(k,) of the angle between the normals of the vertices `index` (k,) and the lines of sight."""
        eye = (T_world_camera[:3, 3] - self.centre).astype(np.float32)
        sight, normals = eye[:, None] - self.vertices[:, index], self.normals[:, index]
        length = np.sqrt(np.einsum("ik,ik->k", sight, sight))
        return np.asarray(np.einsum("ik,ik->k", sight, normals) / np.maximum(length, 1e-9))

    def _along(self, vertices: NDArray[np.float32], T_world_camera: Array) -> list[NDArray[np.float32]]:
        """x, y and z in a camera's frame; not as a product of matrices, whose threads would only wait."""
        R = T_world_camera[:3, :3].astype(np.float32)
        t = ((self.centre - T_world_camera[:3, 3]) @ T_world_camera[:3, :3]).astype(np.float32)
        x, y, z = vertices
        return [R[0, i] * x + R[1, i] * y + R[2, i] * z + t[i] for i in range(3)]

    def depth(self, camera: Camera, T_world_camera: Array) -> NDArray[np.float32]:
        """(h, w) planar z [m] of what a camera sees of the surface, infinite where that is nothing."""
        rays = np.empty((*camera.shape, 6), np.float32)
        rays[..., :3] = T_world_camera[:3, 3] - self.centre
        along = np.dstack([camera.rays(), np.ones(camera.shape, np.float32)])
        rays[..., 3:] = along @ T_world_camera[:3, :3].T.astype(np.float32)  # of length 1 along z: t is z
        return np.asarray(self._scene.cast_rays(self._tensor(rays))["t_hit"].numpy())


@lru_cache(maxsize=4)
def _reach(camera: Camera) -> tuple[float, float]:
    """The steepest x/z and y/z of a camera's pixels, and a little more."""
    wide, high = np.abs(camera.rays()).max(axis=(0, 1)) * 1.02
    return float(wide), float(high)
