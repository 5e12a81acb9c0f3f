"""Holes closed: a screened Poisson surface where nothing was seen, the scan itself where it was.

Kazhdan and Hoppe 2013, by Open3D: the surface of points with normals, closed everywhere. Its vertices near to what was
seen are put onto it; the others are marked. What was seen stays, to the width of a cell of that surface's triangles.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fusion.errors import MeshError
from fusion.mesh.cleanup import fill_small_holes, parts
from fusion.mesh.comparison.distances import MeshSurface
from fusion.mesh.comparison.surface_samples import face_areas, vertex_normals
from fusion.mesh.mesh import Mesh
from fusion.mesh.vertices import vertices_kept
from fusion.printing.base import Base, base_of
from fusion.printing.touching import without_touching

Array = NDArray[np.float64]
CLOSED = "closed"  # scalar of a mesh: 1 where a vertex was not seen but closed
ROOM = 1.1  # of the box that the surface is sought in over that of the points
DEEPEST, COARSEST = 9, 6  # of the octree: 512 cells along the longest side take 10 s and 1 GB
SEEN = 1.5  # cells from the scan up to which a vertex is put onto it
SAME_SIDE = 0.3  # least cosine between the normals there
REAL = 0.05  # least share of seen vertices of a part: the surface may close on itself beside the object


@dataclass(frozen=True)
class ClosedMesh:
    """A closed mesh."""

    # with the scalar "closed"; other scalars and colours are those of the nearest vertex that was seen, NaN and grey
    # where it was closed
    mesh: Mesh
    closed_area: float  # of what was closed [m^2]
    area: float  # of all [m^2]


def close_holes(mesh: Mesh) -> ClosedMesh:
    """Close a mesh that stands upright, z up. MeshError: it has no triangles, or no closed surface comes of it."""
    if not len(mesh.faces):
        raise MeshError("a point cloud cannot be closed", found="no triangles", expected="a mesh")
    normals = vertex_normals(mesh) if mesh.normals is None else mesh.normals.astype(float)
    spacing = _spacing(mesh)
    base = base_of(replace(mesh, normals=normals.astype(np.float32)), spacing)
    shape, cell = _poisson(mesh.vertices, normals, base, spacing)
    shape, seen = _onto(shape, mesh, SEEN * cell)
    if base is not None:
        shape = _flattened(shape, seen, base, cell)
    parted = without_touching(_dressed(shape, seen, mesh))
    # the surface ends where it leaves the box that it was sought in: there the borders are closed by fans
    whole = fill_small_holes(parted, np.inf)
    gone = np.append(parted.scalars[CLOSED], np.ones(len(whole.vertices) - len(parted.vertices), np.float32))
    whole = replace(whole, scalars=whole.scalars | {CLOSED: gone})
    areas = face_areas(whole)
    closed = (gone == 1)[whole.faces].sum(axis=1) >= 2
    return ClosedMesh(whole, float(areas[closed].sum()), float(areas.sum()))


def _spacing(mesh: Mesh) -> float:
    """Median length of the triangles' sides [m]."""
    sides = mesh.vertices[mesh.faces] - mesh.vertices[np.roll(mesh.faces, 1, axis=1)]
    return float(np.median(np.linalg.norm(sides, axis=2)))


def _poisson(points: Array, normals: Array, base: Base | None, spacing: float) -> tuple[Mesh, float]:
    """The closed surface, and the size of its cells [m]."""
    import open3d

    o3d: Any = open3d
    if base is not None:
        points, normals = np.concatenate([points, base.points]), np.concatenate([normals, base.normals])
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    cloud.normals = o3d.utility.Vector3dVector(normals)
    size = ROOM * float(np.ptp(points, axis=0).max())
    depth = int(np.clip(np.ceil(np.log2(size / max(spacing, 1e-9))), COARSEST, DEEPEST))
    # one thread: sums that are added up in the order in which threads end differ from run to run
    found, _ = o3d.geometry.TriangleMesh.create_from_point_cloud_poisson(cloud, depth=depth, scale=ROOM, n_threads=1)
    found.remove_degenerate_triangles()
    found.remove_duplicated_triangles()
    found.remove_unreferenced_vertices()
    shape = Mesh(np.asarray(found.vertices), np.asarray(found.triangles, np.int32))
    if not len(shape.faces):
        raise MeshError("no closed surface comes of this mesh", found="nothing", do="close smaller parts of it")
    return shape, size / 2**depth


def _onto(shape: Mesh, scan: Mesh, reach: float) -> tuple[Mesh, NDArray[np.bool_]]:
    """The surface with its vertices put onto the scan where that is near, and which these are; stray parts left out."""
    surface = MeshSurface(scan)
    found = surface.closest(shape.vertices)
    own = vertex_normals(shape)
    facing = np.einsum("ij,ij->i", own, found.normals) > SAME_SIDE
    seen = (np.abs(found.distances) < reach) & ~found.on_border & facing
    shape = replace(shape, vertices=np.where(seen[:, None], found.points, shape.vertices))
    part, areas = parts(shape)
    share = np.bincount(part, seen, len(areas)) / np.maximum(np.bincount(part, minlength=len(areas)), 1)
    keep = (share > REAL)[part]
    return vertices_kept(shape, keep), seen[keep]


def _flattened(shape: Mesh, seen: NDArray[np.bool_], base: Base, cell: float) -> Mesh:
    """What was closed at the foot lies in its plane, and nothing lies below."""
    vertices = shape.vertices.copy()
    foot = ~seen & (vertices[:, 2] < base.height + cell)
    vertices[foot, 2] = base.height
    return replace(shape, vertices=vertices)


def _dressed(shape: Mesh, seen: NDArray[np.bool_], scan: Mesh) -> Mesh:
    """Colours and scalars of the nearest seen vertex; NaN and grey where nothing was seen."""
    _, nearest = cKDTree(scan.vertices).query(shape.vertices, workers=-1)
    scalars = {name: np.where(seen, values[nearest], np.nan) for name, values in scan.scalars.items()}
    scalars = {name: values.astype(np.float32) for name, values in scalars.items()}
    colors = None if scan.colors is None else np.where(seen[:, None], scan.colors[nearest], GREY).astype(np.uint8)
    normals = vertex_normals(shape).astype(np.float32)
    return replace(shape, normals=normals, colors=colors, scalars=scalars | {CLOSED: (~seen).astype(np.float32)})


GREY = 180  # as of a mesh that no image shows
