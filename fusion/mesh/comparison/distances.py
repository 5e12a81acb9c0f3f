"""Signed distances from points to a mesh (Open3D's ray-casting scene) or to a point cloud (its local planes)."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fusion.errors import MeshError
from fusion.mesh.comparison.surface_samples import face_areas, face_normals, unit, vertex_normals
from fusion.mesh.comparison.winding import wound
from fusion.mesh.mesh import Mesh
from fusion.mesh.vertices import joined

_ON_EDGE = 1e-4  # barycentric: float32 closest points lie this near to the edge or corner they belong to
_CELLS = 64  # along each axis, in whose order points are looked up
_FOR_THREADS = 10_000  # look-ups: fewer are found before threads have started
_NEIGHBOURS = 12  # of a cloud's point, for its plane: few enough to stay local, enough against noise (guess)


@dataclass(frozen=True)
class Closest:
    """What is closest on a surface to each of n points."""

    points: NDArray[np.float64]  # (n, 3) on the surface [m]; on the local plane for point clouds
    normals: NDArray[np.float64]  # (n, 3) outward unit normals there
    distances: NDArray[np.float64]  # (n,) [m], positive outside
    on_border: NDArray[np.bool_]  # (n,) True where the surface ends there: beyond may be what was never seen


class MeshSurface:
    """A mesh made ready for closest points: a search tree, and the normals of its faces, edges and corners.

    Coordinates are centred before they become float32, so the error is 1e-7 of the mesh's size wherever it stands.
    The sign comes from the normal of the closest face, edge or corner (Baerentzen and Aanaes 2005, angle-weighted
    at corners), which needs no closed surface. Faces that look inwards are turned where that
    can be told (`wound`).
    """

    def __init__(self, mesh: Mesh) -> None:
        import open3d

        o3d: Any = open3d  # its stubs know neither lists nor the scene's answers
        whole = joined(Mesh(mesh.vertices, mesh.faces[face_areas(mesh) > 0]))
        if not len(whole.faces):
            raise MeshError("the mesh has no area", found=f"{len(mesh.faces)} faces without area")
        self._centre = (whole.vertices.min(axis=0) + whole.vertices.max(axis=0)) / 2
        self.wound = wound(whole)
        whole, edges = self.wound.mesh, self.wound.edges
        self._corners = whole.faces
        self._scene = o3d.t.geometry.RaycastingScene()
        local = (whole.vertices - self._centre).astype(np.float32)
        self._reach = float(np.abs(local).max())
        self._scene.add_triangles(o3d.core.Tensor(local), o3d.core.Tensor(whole.faces.astype(np.uint32)))
        self._face_normals, self._vertex_normals = face_normals(whole), vertex_normals(whole)
        self._edge_normals, self._edge_open = edges.normals(self._face_normals), edges.count[edges.index] == 1
        self._vertex_open = np.zeros(len(whole.vertices), bool)
        for corner in range(3):  # edge i lies opposite corner i
            ends = whole.faces[self._edge_open[:, corner]]
            self._vertex_open[np.delete(ends, corner, axis=1).ravel()] = True

    def closest(self, points: NDArray[np.float64], normals: NDArray[np.float64] | None = None) -> Closest:
        """Closest points of `points` (n, 3) [m]; `normals` are not needed here."""
        import open3d

        o3d: Any = open3d
        if not len(points):
            empty = np.zeros((0, 3))
            return Closest(empty, empty, np.zeros(0), np.zeros(0, bool))
        local = (points - self._centre).astype(np.float32)
        order = _by_place(local, self._reach)
        place = np.empty_like(order)  # of each point in that order
        place[order] = np.arange(len(order))
        found = self._scene.compute_closest_points(o3d.core.Tensor(local[order]))
        near = found["points"].numpy()[place].astype(np.float64) + self._centre
        face = found["primitive_ids"].numpy()[place].astype(np.int64)
        uv = found["primitive_uvs"].numpy()[place]
        weights = np.column_stack([1 - uv.sum(axis=1), uv])  # of the three corners
        normal, border = self._normals(face, weights)
        offset = points - near
        sign = np.where(np.einsum("ij,ij->i", offset, normal) < 0, -1.0, 1.0)
        return Closest(near, normal, sign * np.linalg.norm(offset, axis=1), border)

    def hit(self, points: NDArray[np.float64], ways: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Does a ray from each point (..., 3) [m] along its unit vector (..., 3) meet the mesh, but where it starts?"""
        import open3d

        o3d: Any = open3d
        start = points - self._centre + _ON_EDGE * self._reach * ways
        rays = np.concatenate([start, ways], axis=-1).astype(np.float32)
        return np.asarray(self._scene.test_occlusions(o3d.core.Tensor(rays)).numpy(), np.bool_)

    def _normals(
        self, face: NDArray[np.int64], weights: NDArray[np.float32]
    ) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        outside = weights < _ON_EDGE  # corners without a share
        normal = self._face_normals[face]
        border = np.zeros(len(face), bool)
        zeros = outside.sum(axis=1)
        rows = np.flatnonzero(zeros == 1)
        edge = np.argmax(outside[rows], axis=1)
        normal[rows], border[rows] = self._edge_normals[face[rows], edge], self._edge_open[face[rows], edge]
        rows = np.flatnonzero(zeros == 2)
        corner = self._corners[face[rows], np.argmax(weights[rows], axis=1)]
        normal[rows], border[rows] = self._vertex_normals[corner], self._vertex_open[corner]
        return normal, border


def _by_place(points: NDArray[np.float32], reach: float) -> NDArray[np.intp]:
    """An order (n,) of points (n, 3) within a reach, in which neighbours follow each other.

    What one of them looks up in the search tree is still in the cache for the next: a third of the time.
    """
    cells = np.clip((np.nan_to_num(points) / reach + 1) * (_CELLS / 2), 0, _CELLS - 1).astype(np.intp)
    return np.argsort((cells[:, 0] * _CELLS + cells[:, 1]) * _CELLS + cells[:, 2])


class CloudSurface:
    """A point cloud made ready for closest points: between the points the surface is their local plane.

    Where a point lies beside the cloud (further along the plane than the points are apart), the distance is the one to
    the nearest point. Without normals the planes are fitted, and look where the query's normals look, or, without
    these, away from the cloud's middle.
    """

    def __init__(self, cloud: Mesh) -> None:
        self.points = cloud.vertices
        if len(self.points) < 3:
            found = f"{len(self.points)} points"
            raise MeshError("too few points to compare with", found=found, expected="at least 3")
        self._tree, self._middle = cKDTree(self.points), self.points.mean(axis=0)
        self._reach = np.full(len(self.points), np.nan)  # until it is asked for, as planes that are fitted
        self.known_normals = cloud.normals is not None
        self.normals = (
            np.full((len(self.points), 3), np.nan) if cloud.normals is None else unit(cloud.normals.astype(np.float64))
        )

    def _fit(self, index: NDArray[np.intp]) -> None:
        """The planes of points, by their numbers (n,)."""
        new = np.unique(index[np.isnan(self._reach[index])])
        count = min(_NEIGHBOURS, len(self.points))
        apart, beside = self._tree.query(self.points[new], k=count, workers=workers_for(len(new)))
        if not self.known_normals:
            near = self.points[beside] - self.points[beside].mean(axis=1, keepdims=True)
            normals = np.linalg.eigh(np.einsum("nki,nkj->nij", near, near))[1][:, :, 0]
            normals[np.einsum("ij,ij->i", normals, self.points[new] - self._middle) < 0] *= -1
            self.normals[new] = normals
        # last: another thread takes a plane for known that has its reach, and else finds the same one
        self._reach[new] = np.maximum(1.5 * apart[:, min(6, count - 1)], 1e-12)

    def closest(self, points: NDArray[np.float64], normals: NDArray[np.float64] | None = None) -> Closest:
        """Closest points of `points` (n, 3) [m] whose outward `normals` (n, 3) tell the side, if the cloud does not."""
        _, index = self._tree.query(points, workers=workers_for(len(points)))
        self._fit(index)
        normal, offset = self.normals[index], points - self.points[index]
        if normals is not None and not self.known_normals:
            normal = np.where(np.einsum("ij,ij->i", normal, normals)[:, None] < 0, -normal, normal)
        height = np.einsum("ij,ij->i", offset, normal)
        beside = np.linalg.norm(offset - height[:, None] * normal, axis=1) > self._reach[index]
        length = np.where(beside, np.linalg.norm(offset, axis=1), np.abs(height))
        near = np.where(beside[:, None], self.points[index], points - height[:, None] * normal)
        return Closest(near, normal, np.where(height < 0, -length, length), beside)


def workers_for(count: int) -> int:
    """For so many look-ups: of few of them threads take longer to start than to find."""
    return -1 if count > _FOR_THREADS else 1


Surface = MeshSurface | CloudSurface


def surface_of(mesh: Mesh) -> Surface:
    """The mesh or point cloud made ready for closest points."""
    return MeshSurface(mesh) if len(mesh.faces) else CloudSurface(mesh)


def signed_distances(points: NDArray[np.float64], reference: Mesh) -> NDArray[np.float64]:
    """Distances (n,) [m] of points (n, 3) to the reference, positive outside of it."""
    return surface_of(reference).closest(points).distances
