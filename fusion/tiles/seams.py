"""What the pieces of a mesh share: vertices on seams, and connected parts that reach over them.

Two pieces are looked at at a time: where a floor lies in the plane between tiles, every vertex of it is on a seam.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fusion.progress import each
from fusion.tiles.piece import Filed
from fusion.tiles.tile import HALO
from fusion.volume.settings import BLOCK


@dataclass(frozen=True)
class Seams:
    """How the pieces hang together; q parts of all pieces, one piece after the other."""

    first: NDArray[np.int64]  # (pieces + 1,) number of the first part of each piece, and q
    whole: NDArray[np.int32]  # (q,) which connected part of the whole mesh each belongs to
    # low, high: (wholes, 3) box around each of these [m]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    area: NDArray[np.float64]  # (wholes,) [m^2]
    # vertices, faces: (q,) how many each part has
    vertices: NDArray[np.int64]
    faces: NDArray[np.int64]

    def kept(self, size: float) -> NDArray[np.bool_]:
        """Which parts (q,) belong to a whole with a diagonal of at least `size` [m], or to the largest.

        As `mesh.cleanup.without_crumbs` has it.
        """
        keep = np.linalg.norm(self.high - self.low, axis=1) >= size
        keep[np.argmax(self.area)] = True
        return np.asarray(keep[self.whole])


def seams(pieces: Sequence[Filed]) -> Seams:
    """Look at all pieces, one or more, and join their parts."""
    boxes, counts, pairs = [], [], []
    first = np.concatenate([[0], np.cumsum([piece.count("area") for piece in pieces])])
    for index, piece in enumerate(each(pieces, "seams")):
        own, part, faces = piece.count("vertices"), piece.array("part"), piece.array("faces")
        parts = int(first[index + 1] - first[index])
        counts.append([np.bincount(part[:own], minlength=parts), np.bincount(part[faces[:, 0]], minlength=parts)])
        boxes.append([piece.array("low"), piece.array("high")])
        for owner, wanted, vertices in borrowed(pieces, index):
            theirs = pieces[owner].array("part")[vertices] + first[owner]
            pairs.append(np.unique(np.stack([part[own + wanted] + first[index], theirs]), axis=1))
    count = int(first[-1])
    edges = np.concatenate([np.zeros((2, 0), np.int64), *pairs], axis=1)
    graph = coo_array((np.ones(edges.shape[1], np.int8), (edges[0], edges[1])), (count, count))
    wholes, whole = connected_components(graph, directed=False)
    low, high = np.full((wholes, 3), np.inf), np.full((wholes, 3), -np.inf)
    np.minimum.at(low, whole, np.concatenate([box[0] for box in boxes]))
    np.maximum.at(high, whole, np.concatenate([box[1] for box in boxes]))
    area = np.bincount(whole, np.concatenate([piece.array("area") for piece in pieces]), minlength=wholes)
    vertices, faces = (np.concatenate([pair[k] for pair in counts]) for k in (0, 1))
    return Seams(first, whole, low, high, area.astype(float), vertices, faces)


def borrowed(pieces: Sequence[Filed], index: int) -> Iterator[tuple[int, NDArray[np.int64], NDArray[np.int64]]]:
    """The vertices that a piece has from others.

    Returns:
        For each owner its number, which of the piece's foreign vertices (k,) these are, and which vertices (k,) of the
        owner.
    """
    keys = pieces[index].array("foreign_keys")
    blocks, tile, left = keys[:, :3] // BLOCK, pieces[index].tile, len(keys)
    for owner, other in enumerate(pieces):
        apart = np.greater(other.tile.low, np.add(tile.high, HALO)) | np.less(
            other.tile.high, np.subtract(tile.low, HALO)
        )
        if owner == index or apart.any():
            continue
        wanted = np.flatnonzero(other.tile.holds(blocks))
        if not len(wanted):
            continue
        corner = np.multiply(other.tile.low, BLOCK)
        seam, asked = _packed(other.array("seam_keys"), corner), _packed(keys[wanted], corner)
        order = np.argsort(seam)
        at = order[np.minimum(np.searchsorted(seam, asked, sorter=order), len(order) - 1)]
        if not (seam[at] == asked).all():
            raise AssertionError("a vertex on a seam is not its owner's")
        left -= len(wanted)
        yield owner, wanted, other.array("seam")[at].astype(np.int64)
    if left:
        raise AssertionError("a vertex on a seam belongs to no tile")


def _packed(keys: NDArray[np.int32], corner: NDArray[np.int64]) -> NDArray[np.int64]:
    """Edges (n, 4) as one number each, which they keep within a tile of up to 2^20 voxels along an edge."""
    x, y, z = (keys[:, :3] - corner).astype(np.int64).T
    return ((x << 40 | y << 20 | z) << 2) | keys[:, 3]
