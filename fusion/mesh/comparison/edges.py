"""The edges of a mesh: which faces meet at each of them, and which way round these run along it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.comparison.surface_samples import unit
from fusion.mesh.mesh import Mesh


@dataclass(frozen=True)
class MeshEdges:
    """The e edges of m faces."""

    index: NDArray[np.intp]  # (m, 3) number of the edge opposite corner i
    way: NDArray[np.int8]  # (m, 3) 1 where the face runs from the edge's lower vertex to its higher one, else -1
    count: NDArray[np.intp]  # (e,) faces there

    @classmethod
    def of(cls, mesh: Mesh) -> "MeshEdges":
        """Of the vertices as they are numbered: what stands at one place ought to be `joined`."""
        runs = mesh.faces[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2).astype(np.int64)
        code = runs.min(axis=1) * len(mesh.vertices) + runs.max(axis=1)
        _, index, count = np.unique(code, return_inverse=True, return_counts=True)
        way = np.where(runs[:, 0] < runs[:, 1], 1, -1).astype(np.int8)
        return cls(index.reshape(-1, 3), way.reshape(-1, 3), count)

    def turned(self, rows: NDArray[np.bool_]) -> "MeshEdges":
        """With those of the faces (m,) turned round: their corners in the opposite order."""
        index, way = self.index.copy(), self.way.copy()
        index[rows], way[rows] = index[rows, ::-1], -way[rows, ::-1]
        return MeshEdges(index, way, self.count)

    def balance(self) -> NDArray[np.float64]:
        """(e,) faces that run forth less those that run back: 0 where a surface goes on, looking the same way."""
        return np.bincount(self.index.ravel(), self.way.ravel(), len(self.count)).astype(np.float64)

    def pairs(self) -> NDArray[np.intp]:
        """(k, 2) places in the flat index, where exactly two faces meet."""
        first, last = np.zeros((2, len(self.count)), np.intp)
        flat, place = self.index.ravel(), np.arange(self.index.size)
        last[flat], first[flat[::-1]] = place, place[::-1]
        two = self.count == 2
        return np.column_stack([first[two], last[two]])

    def normals(self, of_faces: NDArray[np.float64]) -> NDArray[np.float64]:
        """(m, 3, 3) at each face's edges the mean of the faces' normals (m, 3) there."""
        edge, each = self.index.ravel(), np.repeat(of_faces, 3, axis=0)
        total = np.column_stack([np.bincount(edge, each[:, axis]) for axis in range(3)]).astype(float)
        return unit(total)[edge].reshape(-1, 3, 3)
