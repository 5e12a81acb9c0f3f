"""Clean-up of a scanned mesh: crumbs and small holes."""

from collections import defaultdict

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fusion.mesh.comparison.surface_samples import face_areas
from fusion.mesh.mesh import Mesh
from fusion.mesh.vertices import vertices_added, vertices_kept


def large_parts(mesh: Mesh, share: float) -> tuple[Mesh, float]:
    """The connected parts that hold at least this share of the surface, or the largest; and the share that they hold.

    Vertices without a face are left out.
    """
    if not len(mesh.faces):
        return mesh, 0.0
    part, areas = parts(mesh)
    keep = areas >= min(share * float(areas.sum()), float(areas.max()))
    return vertices_kept(mesh, keep[part]), float(areas[keep].sum() / areas.sum())


def without_crumbs(mesh: Mesh, size: float) -> Mesh:
    """The connected parts whose bounding box has a diagonal of at least `size` [m], and always the largest of them."""
    if not len(mesh.faces):
        return mesh
    part, areas = parts(mesh)
    order = np.argsort(part, kind="stable")
    start = np.searchsorted(part[order], np.arange(len(areas)))
    low, high = (f.reduceat(mesh.vertices[order], start, axis=0) for f in (np.minimum, np.maximum))
    keep = np.linalg.norm(high - low, axis=1) >= size
    keep[np.argmax(areas)] = True
    return vertices_kept(mesh, keep[part])


def fill_small_holes(mesh: Mesh, max_perimeter: float) -> Mesh:
    """Close holes whose border is no longer than `max_perimeter` [m], each by a fan around its centre.

    The new centres are added behind the old vertices; their normals, colours and scalars are the means of the border's.
    """
    loops = [loop for loop in border_loops(mesh) if _perimeter(mesh, loop) <= max_perimeter]
    if not loops:
        return mesh
    faces = [mesh.faces]
    for number, loop in enumerate(loops):
        centre = np.full(len(loop), len(mesh.vertices) + number)
        # against the border's direction, so that each border edge is used once in either direction
        faces.append(np.stack([np.roll(loop, -1), loop, centre], axis=1))

    def grown(values: NDArray) -> NDArray:
        return np.concatenate([values, [values[loop].mean(axis=0) for loop in loops]])

    return vertices_added(mesh, np.concatenate(faces), grown)


def border_loops(mesh: Mesh) -> list[NDArray[np.int64]]:
    """Closed borders as vertex indices, in the direction of the faces beside them."""
    follows: dict[int, list[int]] = defaultdict(list)
    for start, end in border_edges(mesh).tolist():
        follows[start].append(end)
    loops = []
    for start in list(follows):
        while follows[start]:
            loops += _walk(start, follows)
    return loops


def border_edges(mesh: Mesh) -> NDArray[np.int64]:
    """Edges (k, 2) of faces that no face uses in the other direction."""
    start, end = mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).astype(np.int64).T
    count = len(mesh.vertices)
    # one sort puts both directions of an edge side by side: its smaller and larger vertex, then which way
    key = (np.minimum(start, end) * count + np.maximum(start, end)) * 2 + (start > end)
    key.sort()
    edge, back = key >> 1, (key & 1).astype(bool)
    first = np.flatnonzero(np.diff(edge, prepend=-1))
    last = np.append(first[1:], len(key))
    lonely = np.repeat(back[first] == back[last - 1], last - first) if len(key) else np.zeros(0, bool)
    low, high = np.divmod(edge[lonely], max(count, 1))
    turned = back[lonely]
    return np.stack([np.where(turned, high, low), np.where(turned, low, high)], axis=1)


def _walk(start: int, follows: dict[int, list[int]]) -> list[NDArray[np.int64]]:
    """Loops met on one walk; where borders touch in a vertex, each closes there on its own."""
    loops = []
    path, place = [start], {start: 0}
    while follows[path[-1]]:
        vertex = follows[path[-1]].pop()
        if vertex not in place:
            place[vertex] = len(path)
            path.append(vertex)
            continue
        first = place[vertex]
        loops.append(np.array(path[first:], np.int64))
        for gone in path[first + 1 :]:
            del place[gone]
        del path[first + 1 :]
    return [loop for loop in loops if len(loop) >= 3]


def _perimeter(mesh: Mesh, loop: NDArray[np.int64]) -> float:
    corners = mesh.vertices[loop]
    return float(np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1).sum())


def parts(mesh: Mesh) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """The part of each vertex, and each part's surface [m^2]."""
    edges = mesh.faces[:, [0, 1, 1, 2]].reshape(-1, 2)
    shape = (len(mesh.vertices), len(mesh.vertices))
    graph = coo_array((np.ones(len(edges), np.int8), (edges[:, 0], edges[:, 1])), shape)
    number, part = connected_components(graph, directed=False)
    part = np.asarray(part, np.int32)
    return part, np.bincount(part[mesh.faces[:, 0]], face_areas(mesh), minlength=number).astype(float)
