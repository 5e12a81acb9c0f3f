"""What the pieces of a mesh share: vertices on seams, and connected parts that reach over them."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fusion.progress import each
from fusion.tiles.piece import Piece


@dataclass(frozen=True)
class Seams:
    """How the pieces hang together; q parts of all pieces, one piece after the other, and s vertices on seams.

    Attributes:
        first: (pieces + 1,) number of the first part of each piece, and q.
        whole: (q,) which connected part of the whole mesh each belongs to.
        low, high: (wholes, 3) box around each of these [m].
        area: (wholes,) [m^2].
        vertices, faces: (q,) how many each part has.
        seam: of each piece the number (0 to s - 1) of each of its seam vertices.
        foreign: of each piece the number of each of its foreign vertices.
    """

    first: NDArray[np.int64]
    whole: NDArray[np.int32]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    area: NDArray[np.float64]
    vertices: NDArray[np.int64]
    faces: NDArray[np.int64]
    seam: list[NDArray[np.int64]]
    foreign: list[NDArray[np.int64]]

    def kept(self, size: float) -> NDArray[np.bool_]:
        """Which parts (q,) belong to a whole with a diagonal of at least `size` [m], or to the largest.

        As `mesh.cleanup.without_crumbs` has it.
        """
        keep = np.linalg.norm(self.high - self.low, axis=1) >= size
        keep[np.argmax(self.area)] = True
        return np.asarray(keep[self.whole])


@dataclass(frozen=True)
class _Rim:
    """What is needed of a piece to join it."""

    keys: NDArray[np.int32]
    foreign: NDArray[np.int32]
    part_of_seam: NDArray[np.int32]
    part_of_foreign: NDArray[np.int32]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    area: NDArray[np.float64]
    vertices: NDArray[np.int64]
    faces: NDArray[np.int64]


def seams(paths: Sequence[Path]) -> Seams:
    """Look at all pieces, one after the other; at least one."""
    rims = [_rim(Piece.load(path)) for path in each(paths, "seams")]
    first = np.concatenate([[0], np.cumsum([len(rim.area) for rim in rims])])
    owned, wanted = sum(len(rim.keys) for rim in rims), sum(len(rim.foreign) for rim in rims)
    keys = np.concatenate([*(rim.keys for rim in rims), *(rim.foreign for rim in rims)])
    number = np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1)
    part_of = np.full(owned + wanted, -1)
    part_of[number[:owned]] = np.concatenate([rim.part_of_seam + at for rim, at in zip(rims, first, strict=False)])
    theirs = part_of[number[owned:]]
    if (theirs < 0).any():
        raise AssertionError("a vertex on a seam belongs to no tile")
    ours = np.concatenate([rim.part_of_foreign + at for rim, at in zip(rims, first, strict=False)])
    count = int(first[-1])
    graph = coo_array((np.ones(wanted, np.int8), (ours, theirs)), (count, count))
    wholes, whole = connected_components(graph, directed=False)
    low, high = np.full((wholes, 3), np.inf), np.full((wholes, 3), -np.inf)
    np.minimum.at(low, whole, np.concatenate([rim.low for rim in rims]))
    np.maximum.at(high, whole, np.concatenate([rim.high for rim in rims]))
    area = np.bincount(whole, np.concatenate([rim.area for rim in rims]), minlength=wholes).astype(float)
    ends = np.cumsum([0, *(len(rim.keys) for rim in rims), *(len(rim.foreign) for rim in rims)])
    split = [number[a:b] for a, b in pairwise(ends)]
    return Seams(
        first, whole, low, high, area, np.concatenate([rim.vertices for rim in rims]),
        np.concatenate([rim.faces for rim in rims]), split[: len(rims)], split[len(rims) :],
    )  # fmt: skip


def _rim(piece: Piece) -> _Rim:
    own, parts = len(piece.vertices), len(piece.area)
    faces = piece.part[piece.faces[:, 0]]
    return _Rim(
        piece.seam_keys, piece.foreign_keys, piece.part[piece.seam], piece.part[own:], piece.low, piece.high,
        piece.area, np.bincount(piece.part[:own], minlength=parts), np.bincount(faces, minlength=parts),
    )  # fmt: skip
