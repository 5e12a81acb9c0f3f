"""Vertices of a mesh left out or joined, with everything that hangs on them."""

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.mesh import Mesh


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
