"""The part of a mesh where a function of its vertices is positive, cut exactly where that is zero."""

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.mesh import Mesh
from fusion.mesh.vertices import vertices_added, vertices_kept

Array = NDArray[np.float64]
LEAST = 1e-6  # of an edge from its end that is kept to where it is cut: no triangle without an area


def clipped(mesh: Mesh, level: Array) -> Mesh:
    """What lies where `level` (n,) is positive; edges that cross zero get a vertex there.

    New vertices stand behind the old ones; what hangs on them lies between the two ends of their edge.
    """
    inside = level > 0
    count = inside[mesh.faces].sum(axis=1)
    crossing = mesh.faces[(count == 1) | (count == 2)]
    if not len(crossing):
        return vertices_kept(mesh, inside)
    # turn each face so that its one corner on a side of its own comes first
    lonely = inside[crossing] == (inside[crossing].sum(axis=1) == 1)[:, None]
    first = np.argmax(lonely, axis=1)[:, None]
    a, b, c = np.take_along_axis(crossing, (first + np.arange(3)) % 3, axis=1).T
    edges, which = np.unique(np.sort(np.concatenate([[a, b], [a, c]], axis=1).T, axis=1), axis=0, return_inverse=True)
    p, q = which.reshape(2, -1) + len(mesh.vertices)
    one = inside[a]
    faces = [mesh.faces[count == 3], np.stack([a, p, q], axis=1)[one]]
    faces += [np.stack([p, b, c], axis=1)[~one], np.stack([p, c, q], axis=1)[~one]]
    start, end = (
        np.where(inside[edges], edges, edges[:, ::-1])[:, 0],
        np.where(inside[edges], edges[:, ::-1], edges)[:, 0],
    )
    share = np.clip(level[start] / (level[start] - level[end]), LEAST, 1)

    def grown(values: NDArray) -> NDArray:
        part = share.reshape(-1, *[1] * (values.ndim - 1))
        return np.concatenate([values, values[start] * (1 - part) + values[end] * part])

    whole = vertices_added(mesh, np.concatenate(faces), grown)
    return vertices_kept(whole, np.concatenate([inside, np.ones(len(edges), bool)]))
