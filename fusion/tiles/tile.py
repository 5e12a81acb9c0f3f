"""Space in boxes of blocks: each tile owns the blocks of its core, and is fused with a halo of one block around it.

A block's voxels depend on the frames alone and not on the blocks around it, so every block comes out the same in
whichever tile it is fused. Cells and normals need the voxels of neighbouring blocks: that is what the halo is for.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from fusion.volume.settings import BLOCK, VolumeSettings

Corner = tuple[int, int, int]
HALO = 1  # blocks: cells reach one voxel over the border, normals two


@dataclass(frozen=True, order=True)
class Tile:
    """A box of blocks."""

    low: Corner  # (3,) lowest block of the core
    high: Corner  # (3,) first block beyond it

    @property
    def name(self) -> str:
        """Of its file."""
        return "_".join(map(str, (*self.low, *self.high)))

    @property
    def divisible(self) -> bool:
        """It has more than one block along some axis."""
        return bool(np.subtract(self.high, self.low).max() > 1)

    def parts(self) -> Iterator["Tile"]:
        """The tile halved along each axis that has more than one block."""
        low, high = np.array(self.low), np.array(self.high)
        middle = np.where(high - low > 1, (low + high + 1) // 2, high)
        ends = [
            [(low[a], middle[a]), (middle[a], high[a])] if middle[a] < high[a] else [(low[a], high[a])]
            for a in range(3)
        ]
        for spans in product(*ends):
            first, last = zip(*spans, strict=True)
            yield Tile(_corner(first), _corner(last))

    def holds(self, blocks: NDArray[np.int32]) -> NDArray[np.bool_]:
        """Which blocks (n, 3) belong to the core."""
        return np.asarray(((blocks >= self.low) & (blocks < self.high)).all(axis=1))

    def settings(self, settings: VolumeSettings) -> VolumeSettings | None:
        """Of a volume of the tile and its halo, within the bounds of the whole; None where they leave nothing."""
        edge = settings.voxel * BLOCK
        low, last = np.subtract(self.low, HALO), np.add(self.high, HALO) - 1
        if settings.bounds is not None:
            ends = np.floor(np.array(settings.bounds) / edge).astype(int)
            low, last = np.maximum(low, ends[0]), np.minimum(last, ends[1])
        if (low > last).any():
            return None
        # through the blocks' middles, where rounding changes nothing; a hair apart, for a box has a size
        bounds = ((low + 0.49) * edge).tolist(), ((last + 0.51) * edge).tolist()
        return replace(settings, bounds=(tuple(bounds[0]), tuple(bounds[1])))

    def reached(self, boxes: NDArray[np.float64], edge: float) -> bool:
        """Some of the boxes (n, 2, 3) [m] meets the tile with its halo; `edge` of a block [m]."""
        low, high = (np.array(self.low) - HALO) * edge, (np.array(self.high) + HALO) * edge
        return bool(((boxes[:, 0] <= high) & (boxes[:, 1] >= low)).all(axis=1).any())


def tiles_of(boxes: NDArray[np.float64], edge: float, blocks: int) -> set[Tile]:
    """The tiles of a regular grid, `blocks` of `edge` [m] along each side, that boxes (n, 2, 3) [m] meet."""
    low, high = (np.floor(boxes[:, end] / (edge * blocks)).astype(np.int64) for end in (0, 1))
    found = set(map(tuple, low.tolist()))
    for first, last in zip(*(end[(low != high).any(axis=1)].tolist() for end in (low, high)), strict=True):
        found.update(product(*(range(a, b + 1) for a, b in zip(first, last, strict=True))))
    return {Tile(_corner(np.multiply(at, blocks)), _corner(np.add(at, 1) * blocks)) for at in found}


def _corner(values: object) -> Corner:
    x, y, z = np.asarray(values).tolist()
    return x, y, z
