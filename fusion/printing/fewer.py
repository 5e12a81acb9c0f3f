"""Fewer triangles, with how far that moved the surface; and a smoother surface."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fusion.mesh.comparison.distances import surface_of
from fusion.mesh.comparison.surface_samples import sample_surface, vertex_normals
from fusion.mesh.mesh import Mesh
from fusion.printing.touching import without_touching

SAMPLES = 20_000  # points that tell how far a surface was moved, each way
CLOSER, BACK = 0.5, -0.53  # of a step of smoothing, and of the one back that keeps the size (Taubin 1995)


def decimated(mesh: Mesh, triangles: int) -> Mesh:
    """At most about so many triangles, by quadric errors (Garland and Heckbert 1997, by Open3D).

    Colours and scalars are those of the nearest vertex before.
    """
    if len(mesh.faces) <= triangles:
        return mesh
    import open3d

    o3d: Any = open3d
    whole = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(mesh.vertices), o3d.utility.Vector3iVector(mesh.faces.astype(np.int32))
    )
    less = whole.simplify_quadric_decimation(int(triangles))
    less.remove_unreferenced_vertices()
    made = Mesh(np.asarray(less.vertices), np.asarray(less.triangles, np.int32))
    return without_touching(dressed_as(made, mesh))


def smoothed(mesh: Mesh, steps: int) -> Mesh:
    """Taubin's smoothing, so many steps forth and back: it keeps the size, as far as the noise has none."""
    import open3d

    o3d: Any = open3d
    whole = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(mesh.vertices), o3d.utility.Vector3iVector(mesh.faces.astype(np.int32))
    )
    calm = whole.filter_smooth_taubin(int(steps), CLOSER, BACK)
    moved = replace(mesh, vertices=np.asarray(calm.vertices))
    return replace(moved, normals=vertex_normals(moved).astype(np.float32))


def dressed_as(made: Mesh, before: Mesh) -> Mesh:
    """A mesh with its own normals, and colours and scalars of the nearest vertices of another."""
    _, nearest = cKDTree(before.vertices).query(made.vertices, workers=-1)
    return replace(
        made,
        normals=vertex_normals(made).astype(np.float32),
        colors=None if before.colors is None else before.colors[nearest],
        scalars={name: values[nearest] for name, values in before.scalars.items()},
    )


def moved_by(before: Mesh, after: Mesh) -> tuple[float, float]:
    """Root mean square and largest distance between two surfaces, both ways, at points of them [m]."""
    there = surface_of(before).closest(sample_surface(after, SAMPLES).points).distances
    back = surface_of(after).closest(sample_surface(before, SAMPLES).points).distances
    away: NDArray[np.float64] = np.abs(np.concatenate([there, back]))
    return float(np.sqrt(np.mean(away**2))), float(away.max())
