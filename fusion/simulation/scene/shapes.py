"""Simple coloured meshes to build scenes from."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.mesh import Mesh

Points = NDArray[np.float64]


def joined(meshes: Sequence[Mesh]) -> Mesh:
    """Several coloured meshes as one; vertex normals and scalars are kept when all have them."""
    if not meshes:
        return Mesh(np.zeros((0, 3)), colors=np.zeros((0, 3), np.uint8))
    starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes[:-1]])
    grey = [np.full(mesh.vertices.shape, 180, np.uint8) if mesh.colors is None else mesh.colors for mesh in meshes]
    normals = [mesh.normals for mesh in meshes if mesh.normals is not None]
    shared = set.intersection(*(set(mesh.scalars) for mesh in meshes))
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]).astype(np.int32),
        np.concatenate(normals) if len(normals) == len(meshes) else None,
        np.concatenate(grey),
        {name: np.concatenate([mesh.scalars[name] for mesh in meshes]) for name in meshes[0].scalars if name in shared},
    )


def disc(radius: float, bottom: float, top: float, paint: Callable[[Points], Points]) -> Mesh:
    """An upright closed cylinder about the z axis [m], fine enough to be painted by position."""
    sectors, rings = 180, np.linspace(0, radius, 40)[1:]
    around = 2 * np.pi * np.arange(sectors) / sectors
    circle = np.column_stack([np.cos(around), np.sin(around)])
    flat = np.concatenate([r * circle for r in rings])
    upper = np.column_stack([flat, np.full(len(flat), top)])
    lower = np.column_stack([radius * circle, np.full(sectors, bottom)])
    vertices = np.concatenate([upper, lower, [[0, 0, top], [0, 0, bottom]]])
    i, j = np.arange(sectors), (np.arange(sectors) + 1) % sectors
    outer, below = (len(rings) - 1) * sectors, len(rings) * sectors
    centre = len(vertices) - 2
    faces = [np.column_stack([np.full(sectors, centre), i, j])]
    for ring in range(len(rings) - 1):
        a, b = ring * sectors, (ring + 1) * sectors
        faces += [np.column_stack([a + i, b + i, b + j]), np.column_stack([a + i, b + j, a + j])]
    faces += [np.column_stack([outer + i, below + i, below + j]), np.column_stack([outer + i, below + j, outer + j])]
    faces += [np.column_stack([np.full(sectors, centre + 1), below + j, below + i])]
    return Mesh(vertices, np.concatenate(faces).astype(np.int32), colors=paint(vertices).astype(np.uint8))


def box(low: tuple[float, float, float], high: tuple[float, float, float], color: tuple[int, int, int]) -> Mesh:
    """An upright box between two corners [m]."""
    corner = np.array(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij")).reshape(3, -1).T
    vertices = np.where(corner == 1, high, low).astype(float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))]
    return Mesh(vertices, np.array(faces, np.int32), colors=np.tile(np.array(color, np.uint8), (8, 1)))


def sheet(origin: Points, along: Points, across: Points, paint: Callable[[Points], Points]) -> Mesh:
    """A flat rectangle from one corner along two edges [m], fine enough to be painted by position."""
    n = 120
    s, t = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
    vertices = np.asarray(origin, float) + s.reshape(-1, 1) * along + t.reshape(-1, 1) * across
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate([np.column_stack([a, a + n, a + n + 1]), np.column_stack([a, a + n + 1, a + 1])])
    return Mesh(vertices, faces.astype(np.int32), colors=paint(vertices).astype(np.uint8))
