"""A lighter mesh for display: what turns smoothly on a small computer."""

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import Array
from fusion.mesh.mesh import Mesh

TRIANGLES = 140_000  # more makes turning slow on small computers (guess); thinning takes 0.7 s to save 0.7 MB
POINTS = 60_000


def thinned(mesh: Mesh, triangles: int = TRIANGLES) -> tuple[Mesh, NDArray[np.int64]]:
    """A lighter mesh for display, and for each of its vertices the nearest one (k,) of the full mesh."""
    from scipy.spatial import cKDTree

    finite = np.flatnonzero(np.isfinite(mesh.vertices).all(axis=1))
    if len(mesh.faces) == 0:
        keep = finite[:: max(1, -(-len(finite) // POINTS))]
        return Mesh(mesh.vertices[keep]), keep
    known = np.asarray(np.isfinite(mesh.vertices).all(axis=1))
    faces = mesh.faces[known[mesh.faces].all(axis=1)]
    vertices = mesh.vertices
    if len(faces) > triangles:
        vertices, faces = _decimated(np.nan_to_num(vertices), faces, triangles)
    used, inverse = np.unique(faces, return_inverse=True)
    vertices = vertices[used]
    _, nearest = cKDTree(mesh.vertices[finite]).query(vertices)
    return Mesh(vertices, inverse.reshape(-1, 3).astype(np.int32)), finite[nearest]


def _decimated(vertices: Array, faces: NDArray[np.int32], triangles: int) -> tuple[Array, NDArray[np.int32]]:
    """Fewer triangles: first vertex clustering where there are very many, then quadric collapse, which keeps edges."""
    import open3d as o3d

    legacy = o3d.geometry.TriangleMesh(o3d.utility.Vector3dVector(vertices), o3d.utility.Vector3iVector(faces))
    legacy.remove_unreferenced_vertices()
    area = legacy.get_surface_area()
    if len(faces) > 4 * triangles and area > 0:
        # cells of edge e hold about 2 triangles per e^2 of surface: aim at twice the goal, as collapsing is slow
        legacy = legacy.simplify_vertex_clustering(float(np.sqrt(2 * area / (2 * triangles))))
    legacy = legacy.simplify_quadric_decimation(triangles)
    return np.asarray(legacy.vertices), np.asarray(legacy.triangles, np.int32)
