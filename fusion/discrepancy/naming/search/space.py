"""Space: units in which only counts what the parts named so far do not explain."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference.sizes import orthonormal
from fusion.discrepancy.naming.effect_part import EffectPart

Matrix = NDArray[np.float64]

FREE = 1e4  # a direction that may take any size keeps this part of it, to the power of -1


@dataclass(frozen=True)
class Space:
    """Whitened vectors with some directions taken out, or damped by how large a field is there.

    Attributes:
        directions: (n, m) orthonormal.
        kept: (m,) factor of what stays of each.
    """

    directions: Matrix
    kept: NDArray[np.float64]

    def of(self, values: Matrix) -> Matrix:
        """Vectors (n,) or (n, k) in this space."""
        if not len(self.kept):
            return values
        along = self.directions.T @ values
        return np.asarray(values - self.directions @ ((1 - self.kept) * along.T).T)


class Aim(NamedTuple):
    """What is to be explained: a vector (n,), and the space in which it counts."""

    space: Space
    target: NDArray[np.float64]


def space_beside(parts: Sequence[EffectPart], free: Sequence[Matrix], n: int) -> Space:
    """What stays to be explained beside parts; `free` are further columns (n, k) that may take any size."""
    blocks = []
    for part in parts:
        white = part.candidate.white
        blocks.append(white * part.size if part.size else _any(white))
    blocks += [_any(columns) for columns in free if columns.shape[1]]
    if not blocks:
        return Space(np.zeros((n, 0)), np.zeros(0))
    left, sizes, _ = np.linalg.svd(np.concatenate(blocks, axis=1), full_matrices=False)
    seen = sizes > 1e-3
    return Space(left[:, seen], 1.0 / np.sqrt(1.0 + sizes[seen] ** 2))


def _any(white: Matrix) -> Matrix:
    """Columns that span the same, so long that nothing of them stays."""
    return orthonormal(white) * FREE
