"""One mesh file from its pieces, read one after the other: first all vertices, then all faces."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import VolumeError
from fusion.mesh.mesh import Mesh
from fusion.mesh.ply import exact_in_float32, face_rows, header, vertex_rows
from fusion.progress import each
from fusion.tiles.piece import Filed
from fusion.tiles.seams import borrowed, seams

MOST = (1 << 31) - 1  # vertices that the faces of a PLY file can name


@dataclass(frozen=True)
class Streamed:
    """What was written."""

    # vertices, faces: how many
    vertices: int
    faces: int
    parts: tuple[int, int]  # connected ones that were kept, and how many were left out as crumbs
    area: float  # of the surface [m^2]
    # low, high: (3,) its box [m]
    low: tuple[float, float, float]
    high: tuple[float, float, float]


def stream(pieces: Sequence[Filed], path: Path, crumb: float) -> Streamed:
    """Write the mesh of all pieces as PLY, without connected parts whose box has a smaller diagonal than `crumb` [m].

    Raises:
        VolumeError: there is no surface, or more vertices than a PLY file can name.
    """
    if not pieces:
        raise VolumeError("nothing was fused", found="no surface", do="check --box, --poses and --max-depth")
    joined = seams(pieces)
    keep = joined.kept(crumb)
    vertices, faces = int(joined.vertices[keep].sum()), int(joined.faces[keep].sum())
    if vertices > MOST:
        do = "cut it into several with --box"
        raise VolumeError("the mesh is too large for one file", path, f"{vertices} vertices", f"at most {MOST}", do)
    wholes = np.unique(joined.whole[keep])
    low, high = joined.low[wholes].min(axis=0), joined.high[wholes].max(axis=0)
    numbers = VertexNumbers(pieces, joined.first, keep, np.cumsum(np.where(keep, joined.vertices, 0)))
    with path.open("wb") as file:
        for index, piece in enumerate(each(pieces, "vertices")):
            own = numbers.kept(index)
            mesh = Mesh(piece.array("vertices")[own], normals=piece.array("normals")[own])
            rows = vertex_rows(mesh, exact_in_float32(np.stack([low, high])))
            if index == 0:
                file.write(header(rows.dtype, vertices, faces))
            file.write(rows.tobytes())
        for index, piece in enumerate(each(pieces, "faces")):
            corners = piece.array("faces")
            kept = keep[piece.array("part")[corners[:, 0]] + joined.first[index]]
            file.write(face_rows(numbers.of(index)[corners[kept]].astype(np.int32)).tobytes())
    left_out = len(joined.area) - len(wholes)
    return Streamed(
        vertices, faces, (len(wholes), left_out), float(joined.area[wholes].sum()), _corner(low), _corner(high)
    )  # fmt: skip


@dataclass(frozen=True)
class VertexNumbers:
    """Which number each vertex of each piece has in the whole mesh."""

    pieces: Sequence[Filed]
    first: NDArray[np.int64]  # (pieces + 1,) number of the first part of each piece, and q, the number of all parts
    keep: NDArray[np.bool_]  # (q,) parts that are in the mesh
    until: NDArray[np.int64]  # (q,) vertices of the parts up to and with each that are in the mesh

    def kept(self, index: int) -> NDArray[np.bool_]:
        """Which of a piece's own vertices (n,) are in the mesh."""
        piece = self.pieces[index]
        return self.keep[piece.array("part")[: piece.count("vertices")] + self.first[index]]

    def of(self, index: int) -> NDArray[np.int64]:
        """Numbers (n + k,) of a piece's own vertices and those that it has from others; -1 where they are left out."""
        parts = [self._own(index), np.full(self.pieces[index].count("foreign_keys"), -1, np.int64)]
        for owner, wanted, vertices in borrowed(self.pieces, index):
            parts[1][wanted] = self._own(owner)[vertices]
        return np.concatenate(parts)

    def _own(self, index: int) -> NDArray[np.int64]:
        own, before = self.kept(index), int(self.first[index]) - 1
        return np.where(own, np.cumsum(own) - 1 + (self.until[before] if before >= 0 else 0), -1)


def _corner(values: NDArray[np.float64]) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z
