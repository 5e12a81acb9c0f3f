"""A ray caster of its own: exact depth, normal and colour along every pixel's distorted ray."""

from dataclasses import fields

import numpy as np

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array
from fusion.mesh.mesh import Mesh
from fusion.sensor.view import View, incidence_of

GREY = 180  # colour of a mesh without colours


def render(mesh: Mesh, camera: Camera, T_world_camera: Array) -> View:
    """What a camera sees of a mesh that stands in the world frame; for many views of one mesh, keep a RayCaster."""
    return RayCaster(mesh).view(camera, T_world_camera)


class RayCaster:
    """A mesh prepared for many views."""

    def __init__(self, mesh: Mesh) -> None:
        import open3d as o3d

        self._scene = o3d.t.geometry.RaycastingScene(nthreads=2)
        self._faces = mesh.faces
        colors = mesh.colors if mesh.colors is not None else np.full(mesh.vertices.shape, GREY, np.uint8)
        self._colors = colors.astype(np.float32)
        self._normals = None if mesh.normals is None else mesh.normals.astype(np.float32)
        self._tensor = o3d.core.Tensor.from_numpy
        if len(mesh.faces):
            self._scene.add_triangles(
                self._tensor(np.ascontiguousarray(mesh.vertices, np.float32)),
                self._tensor(np.ascontiguousarray(mesh.faces, np.uint32)),
            )

    def view(self, camera: Camera, T_mesh_camera: Array) -> View:
        """Depth, normals, incidence and colour of every pixel; NaN (black) where the ray meets nothing."""
        height, width = camera.shape
        directions = np.dstack([camera.rays(), np.ones((height, width), np.float32)])
        R = T_mesh_camera[:3, :3].astype(np.float32)
        rays = np.empty((height, width, 6), np.float32)
        rays[..., :3] = T_mesh_camera[:3, 3]
        rays[..., 3:] = directions @ R.T
        if not len(self._faces):
            return _empty(camera)
        hits = self._scene.cast_rays(self._tensor(rays))
        # the directions have z = 1 in the camera frame, so the ray parameter is the planar depth
        depth = hits["t_hit"].numpy()
        seen = np.isfinite(depth)
        depth = np.where(seen, depth, np.nan)
        face = hits["primitive_ids"].numpy()[seen]
        weights = _barycentric(hits["primitive_uvs"].numpy()[seen])
        normals = np.full((height, width, 3), np.nan, np.float32)
        normals[seen] = self._normals_at(face, weights, hits["primitive_normals"].numpy()[seen]) @ R
        away = (normals * directions).sum(axis=-1) > 0  # the inside of a surface, seen through a hole
        normals[away] *= -1
        color = np.zeros((height, width, 3), np.uint8)
        color[seen] = np.round(self._interpolated(self._colors, face, weights))
        return View(camera, depth, incidence_of(normals, camera), normals, color=color)

    def _interpolated(self, values: np.ndarray, face: np.ndarray, weights: np.ndarray) -> np.ndarray:
        return np.einsum("nk,nkc->nc", weights, values[self._faces[face]])

    def _normals_at(self, face: np.ndarray, weights: np.ndarray, flat: np.ndarray) -> np.ndarray:
        """(n, 3) unit normals in the mesh frame: of the vertices where the mesh has them, else of the faces."""
        normals = flat if self._normals is None else self._interpolated(self._normals, face, weights)
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        return np.divide(normals, length, out=flat.copy(), where=length > 1e-6)


def nearest(first: View, second: View) -> View:
    """Both views of one camera as one: the nearer surface of every pixel."""
    if first.depth is None or second.depth is None:
        raise ValueError("both views need a depth")
    take = (first.depth <= second.depth) | np.isnan(second.depth)
    merged = {}
    for entry in fields(View):
        a, b = getattr(first, entry.name), getattr(second, entry.name)
        if isinstance(a, np.ndarray):
            a = np.where(take if a.ndim == 2 else take[..., None], a, b)
        merged[entry.name] = a
    return View(**merged)


def _barycentric(uv: np.ndarray) -> np.ndarray:
    """(n, 3) weights of a face's corners."""
    return np.column_stack([1 - uv.sum(axis=1), uv])


def _empty(camera: Camera) -> View:
    nothing = np.full(camera.shape, np.nan, np.float32)
    return View(
        camera,
        nothing,
        nothing.copy(),
        np.full((*camera.shape, 3), np.nan, np.float32),
        color=np.zeros((*camera.shape, 3), np.uint8),
    )
