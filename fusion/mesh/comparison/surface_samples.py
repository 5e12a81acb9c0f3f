"""Points spread evenly over a surface, and the normals of its faces and vertices."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fusion.mesh.mesh import Mesh


@dataclass(frozen=True)
class SurfaceSamples:
    """Points on a surface."""

    points: NDArray[np.float64]  # (n, 3) [m]
    normals: NDArray[np.float64] | None  # (n, 3) unit vectors pointing outwards, or None for a point cloud without them

    def every(self, step: int) -> "SurfaceSamples":
        """One of `step` of them."""
        return SurfaceSamples(self.points[::step], None if self.normals is None else self.normals[::step])


def sample_surface(mesh: Mesh, count: int, seed: int = 0) -> SurfaceSamples:
    """About `count` points, equally likely per area; of a point cloud `count` of its points (all, if it has fewer)."""
    rng = np.random.default_rng(seed)
    if not len(mesh.faces):
        chosen = np.arange(len(mesh.vertices))
        if len(chosen) > count:
            chosen = np.sort(rng.choice(len(chosen), count, replace=False))
        normals = None if mesh.normals is None else mesh.normals[chosen].astype(np.float64)
        return SurfaceSamples(mesh.vertices[chosen], normals)
    share = np.cumsum(face_areas(mesh))
    # one point in each of `count` equal slices of the area: as even as a random choice can be
    where = (np.arange(count) + rng.random(count)) / count * share[-1]
    face = np.minimum(np.searchsorted(share, where, side="right"), len(share) - 1)
    a, b = rng.random((2, count, 1))
    a, b = np.where(a + b > 1, 1 - a, a), np.where(a + b > 1, 1 - b, b)
    corners = mesh.vertices[mesh.faces[face]]
    points = corners[:, 0] + a * (corners[:, 1] - corners[:, 0]) + b * (corners[:, 2] - corners[:, 0])
    return SurfaceSamples(points, face_normals(mesh)[face])


def smooth_normals(samples: SurfaceSamples, neighbours: int = 16) -> NDArray[np.float64] | None:
    """Normals (n, 3) averaged over the nearest samples that look the same way: noise tilts single triangles."""
    if samples.normals is None:
        return None
    _, index = cKDTree(samples.points).query(samples.points, k=min(neighbours, len(samples.points)), workers=-1)
    near = samples.normals[index.reshape(len(samples.points), -1)]
    same = np.einsum("nki,ni->nk", near, samples.normals) > 0
    return unit(np.einsum("nki,nk->ni", near, same))


def face_areas(mesh: Mesh) -> NDArray[np.float64]:
    """Area of each face (m,) [m^2]."""
    return 0.5 * np.linalg.norm(_cross(mesh), axis=1)


def face_normals(mesh: Mesh) -> NDArray[np.float64]:
    """Unit normal of each face (m, 3), zero where a face has no area."""
    return unit(_cross(mesh))


def vertex_normals(mesh: Mesh) -> NDArray[np.float64]:
    """Unit normal of each vertex (n, 3), its faces weighted by their angle there, so the mesh's pattern has no say."""
    total, normal = np.zeros_like(mesh.vertices), face_normals(mesh)
    corners = mesh.vertices[mesh.faces]
    for i in range(3):
        to_next = unit(corners[:, (i + 1) % 3] - corners[:, i])
        to_last = unit(corners[:, (i + 2) % 3] - corners[:, i])
        angle = np.arccos(np.clip(np.einsum("ij,ij->i", to_next, to_last), -1, 1))
        for axis in range(3):
            total[:, axis] += np.bincount(mesh.faces[:, i], normal[:, axis] * angle, minlength=len(total))
    return unit(total)


def unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vectors (..., 3) at length 1; zero stays zero."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)


def _cross(mesh: Mesh) -> NDArray[np.float64]:
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    return np.cross(b - a, c - a)
