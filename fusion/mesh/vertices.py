"""Vertices of a mesh left out or joined, with everything that hangs on them."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.mesh import Mesh


def vertices_added(mesh: Mesh, faces: NDArray[np.integer], grown: Callable[[NDArray], NDArray]) -> Mesh:
    """The mesh with more vertices behind its own.

    Args:
        faces: (k, 3) of all vertices.
        grown: values (n, ...) of the vertices with those of the new ones behind them; normals become unit again.
    """
    normals = None if mesh.normals is None else grown(mesh.normals)
    if normals is not None:
        normals = (normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)).astype(np.float32)
    return Mesh(
        vertices=grown(mesh.vertices),
        faces=faces.astype(np.int32),
        normals=normals,
        colors=None if mesh.colors is None else np.rint(grown(mesh.colors)).astype(np.uint8),
        scalars={name: grown(values).astype(np.float32) for name, values in mesh.scalars.items()},
        notes=mesh.notes,
    )


def vertices_kept(mesh: Mesh, keep: NDArray[np.bool_]) -> Mesh:
    """The mesh of the vertices where `keep` (n,) holds, and of the faces whose three corners are all kept."""
    if keep.all():
        return mesh
    index = np.cumsum(keep, dtype=np.int32) - 1
    return Mesh(
        vertices=mesh.vertices[keep],
        faces=index[mesh.faces[keep[mesh.faces].all(axis=1)]].astype(np.int32),
        normals=None if mesh.normals is None else mesh.normals[keep],
        colors=None if mesh.colors is None else mesh.colors[keep],
        scalars={name: values[keep] for name, values in mesh.scalars.items()},
        notes=mesh.notes,
    )


def joined(mesh: Mesh) -> Mesh:
    """Corners at exactly the same place become one vertex (the first one's colour; normals are left out)."""
    order = np.lexsort(mesh.vertices.T)  # equal ones side by side, the file's first one first
    new = np.ones(len(order), bool)
    new[1:] = (np.diff(mesh.vertices[order], axis=0) != 0).any(axis=1)
    if new.all():
        return mesh
    first = np.empty(len(order), np.int64)
    first[order] = order[new][np.cumsum(new) - 1]
    keep = first == np.arange(len(first))
    faces = (np.cumsum(keep) - 1)[first[mesh.faces]]
    return Mesh(mesh.vertices[keep], faces, None, None if mesh.colors is None else mesh.colors[keep])
