"""Tiles: an image cut into squares, each one number; pixels are not replicates, tiles nearly are."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.view import Image

SIDE_PX = 16
ACROSS = 6  # or more of them over the width of an image: the few pixels of a small one see as much as its squares
LEAST_SHARE = 0.3  # of a tile's pixels that must be usable


@dataclass(frozen=True)
class Tiling:
    """Which pixels make which tile of one block."""

    label: NDArray[np.intp]  # (h, w) number of the pixel's tile in this look, -1 where the pixel is not used
    pixels: NDArray[np.float64]  # (n,) pixels of each tile
    cell: NDArray[np.intp]  # (n, 2) row and column of each tile in the grid of squares
    side: int  # of a square [px]

    def __len__(self) -> int:
        return len(self.pixels)

    def mean(self, image: Image) -> NDArray[np.float64]:
        """(n,) mean of an image (h, w) over each tile; what is NaN counts as 0."""
        pixels, first = self.members
        values = np.broadcast_to(image, self.label.shape).ravel().take(pixels)
        if not len(self):
            return np.zeros(0)
        with np.errstate(invalid="ignore"):
            sums = np.add.reduceat(values, first, dtype=float)
        if not np.isfinite(sums).all():
            sums = np.add.reduceat(np.where(np.isfinite(values), values, 0), first, dtype=float)
        return np.asarray(sums / self.pixels)

    @cached_property
    def members(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Places in a flat image of all pixels that are used, tile by tile, and where each of the n tiles begins."""
        used = np.flatnonzero(self.label >= 0)
        number = self.label.ravel()[used]
        ends = np.cumsum(np.bincount(number, minlength=len(self)))
        return used[np.argsort(number, kind="stable")], np.append(0, ends)[:-1]


def usual_side(shape: tuple[int, ...]) -> int:
    """Side [px] of the squares of an image (h, w)."""
    return min(SIDE_PX, max(1, shape[1] // ACROSS))


def tiling(usable: NDArray[np.bool_], side: int | None = None) -> Tiling:
    """Squares of `side` px, usual ones where nothing is said, with enough usable pixels (h, w)."""
    height, width = usable.shape
    side = side or usual_side(usable.shape)
    across = -(-width // side)
    tile = (np.arange(height) // side)[:, None] * across + (np.arange(width) // side)[None, :]
    count = np.bincount(tile[usable], minlength=int(tile.max()) + 1)
    kept = count >= LEAST_SHARE * side**2
    number = np.where(kept, np.cumsum(kept) - 1, -1)
    cells = np.column_stack(np.divmod(np.flatnonzero(kept), across))
    return Tiling(np.where(usable, number[tile], -1), count[kept].astype(float), cells, side)
