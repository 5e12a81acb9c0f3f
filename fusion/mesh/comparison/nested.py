"""Which closed pieces of a mesh stand within which others."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.mesh import Mesh

# by so many of its corners, and rays from each: one that meets an edge may count double, most do not (guesses)
_CORNERS = 8
_WAYS = np.array(
    [[0.53, 0.71, 0.46], [-0.62, 0.33, 0.71], [0.27, -0.87, 0.41], [0.35, 0.49, -0.8], [-0.81, -0.36, -0.47]]
)


def containers(mesh: Mesh, piece: NDArray[np.intp], closed: NDArray[np.intp]) -> dict[int, list[int]]:
    """By the number of each closed piece: those that it is within.

    Args:
        mesh: all of them.
        piece: (m,) of each face.
        closed: (k,) numbers of those that are closed.
    """
    import open3d

    o3d: Any = open3d
    local = (mesh.vertices - (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0)) / 2).astype(np.float32)
    order = np.argsort(piece, kind="stable")
    rows = np.split(order, np.flatnonzero(np.diff(piece[order])) + 1)
    faces = [mesh.faces[rows[k]] for k in closed]
    low, high = (np.array([f(local[own.ravel()], axis=0) for own in faces]) for f in (np.min, np.max))
    few = [own[np.linspace(0, len(own) - 1, _CORNERS).astype(int), 0] for own in faces]
    around: dict[int, list[int]] = {int(k): [] for k in closed}
    for j, k in enumerate(closed):
        within = np.flatnonzero((low >= low[j]).all(axis=1) & (high <= high[j]).all(axis=1))
        within = within[within != j]
        if not len(within):
            continue
        scene = o3d.t.geometry.RaycastingScene()
        scene.add_triangles(o3d.core.Tensor(local), o3d.core.Tensor(faces[j].astype(np.uint32)))
        start = np.repeat(local[np.array([few[i] for i in within])], len(_WAYS), axis=1)
        ways = np.broadcast_to(np.tile(_WAYS, (_CORNERS, 1)), start.shape)
        rays = np.concatenate([start, ways], axis=-1).astype(np.float32)
        odd = scene.count_intersections(o3d.core.Tensor(rays)).numpy() % 2 == 1
        for i in within[odd.mean(axis=1) > 0.5]:
            around[int(closed[i])].append(int(k))
    return around
