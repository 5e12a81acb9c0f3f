"""Colours carried along the surface to where no image looked."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array

from fusion.mesh.mesh import Mesh


def filled(
    mesh: Mesh, colors: NDArray[np.float32], known: NDArray[np.bool_], reach: float
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Colours (n, 3) of a mesh in which unknown vertices took the mean of their neighbours', and who has one (n,).

    Ring by ring along the edges of the mesh, as far as about `reach` [m].

    Args:
        mesh: triangles.
        colors: (n, 3); of unknown vertices they have no meaning.
        known: (n,) vertices with a colour.
        reach: how far colours are carried [m].
    """
    edges = mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    lost = ~known
    edges = edges[lost[edges].any(axis=1)]  # only these pass a colour on
    if not len(edges):
        return colors, known
    length = float(np.median(np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)))
    both = np.concatenate([edges, edges[:, ::-1]])
    shape = (len(known), len(known))
    beside = coo_array((np.ones(len(both), np.float32), (both[:, 0], both[:, 1])), shape).tocsr()
    colors, known = colors.copy(), known.copy()
    for _ in range(int(np.ceil(reach / max(length, 1e-9)))):
        rest = np.flatnonzero(~known)
        around = beside[rest]
        count = around @ known.astype(np.float32)
        new = count > 0
        if not new.any():
            break
        total = around[np.flatnonzero(new)] @ (colors * known[:, None])
        colors[rest[new]] = total / count[new, None]
        known[rest[new]] = True
    return colors, known
