"""Sheets of a surface that touch in an edge or a vertex get corners of their own: each edge has two faces then."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fusion.mesh.mesh import Mesh


def without_touching(mesh: Mesh) -> Mesh:
    """The same surface; faces around a corner that hang together by no edge of two faces get their own copy of it.

    Vertices keep their order; copies stand behind them.
    """
    faces = mesh.faces.astype(np.int64)
    corner = np.arange(faces.size).reshape(faces.shape)  # a corner of a face, of its own
    # edge k of a face goes from corner k to corner k + 1; the same edge of another face the other way round
    start, end = corner.ravel(), np.roll(corner, -1, axis=1).ravel()
    a, b = faces.ravel()[start], faces.ravel()[end]
    key = np.minimum(a, b) * len(mesh.vertices) + np.maximum(a, b)
    order = np.argsort(key, kind="stable")
    _, first, count = np.unique(key[order], return_index=True, return_counts=True)
    two = first[count == 2]
    one, other = order[two], order[two + 1]
    # the same end of the edge in both faces
    straight = a[one] == a[other]
    joined_start = np.where(straight, start[other], end[other])
    joined_end = np.where(straight, end[other], start[other])
    pairs = np.concatenate([np.column_stack([start[one], joined_start]), np.column_stack([end[one], joined_end])])
    graph = coo_array((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), (faces.size, faces.size))
    _, group = connected_components(graph, directed=False)
    return _renamed(mesh, group.reshape(faces.shape), faces)


def _renamed(mesh: Mesh, group: NDArray[np.integer], faces: NDArray[np.int64]) -> Mesh:
    """Each group of corners is a vertex; the first of a vertex keeps its number."""
    groups, at = np.unique(group.ravel(), return_index=True)
    vertex = faces.ravel()[at]  # that the group stands at
    order = np.lexsort((groups, vertex))
    first = np.ones(len(order), bool)
    first[1:] = np.diff(vertex[order]) > 0
    number = np.empty(len(groups), np.int64)
    number[order[first]] = vertex[order[first]]
    copies = order[~first]
    if not len(copies):
        return mesh
    number[copies] = len(mesh.vertices) + np.arange(len(copies))
    lookup = np.empty(int(groups.max()) + 1, np.int64)
    lookup[groups] = number
    source = vertex[copies]
    return replace(
        mesh,
        vertices=np.concatenate([mesh.vertices, mesh.vertices[source]]),
        faces=lookup[group].astype(np.int32),
        normals=None if mesh.normals is None else np.concatenate([mesh.normals, mesh.normals[source]]),
        colors=None if mesh.colors is None else np.concatenate([mesh.colors, mesh.colors[source]]),
        scalars={name: np.concatenate([values, values[source]]) for name, values in mesh.scalars.items()},
    )
