"""Tiles of an image: neighbouring pixels share their errors, so a wall speaks through some hundred means."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

ACROSS = 20  # tiles over the width of the image
FULL = 0.25  # share of a tile's pixels that must be wall


@dataclass(frozen=True)
class TileGrid:
    """Which tile each pixel belongs to."""

    label: NDArray[np.intp]  # (h, w) number of the tile, -1 outside
    count: NDArray[np.int64]  # (t,) pixels in each
    place: NDArray[np.intp]  # (t, 2) row and column in the grid of tiles; squares of a board may share one
    grid: tuple[int, int]  # rows and columns of that grid
    side: int  # edge of a tile [px]

    def mean(self, image: NDArray[np.floating]) -> NDArray[np.floating]:
        """(t,) means of an image that broadcasts to (h, w)."""
        image = np.broadcast_to(np.asarray(image, float), self.label.shape)
        inside = self.label >= 0
        return np.bincount(self.label[inside], image[inside], len(self.count)) / self.count

    def image(self, values: NDArray[np.floating]) -> NDArray[np.floating]:
        """(rows, columns) of the grid from values (t,), NaN where there is no tile; means where there are several."""
        at = self.place[:, 0] * self.grid[1] + self.place[:, 1]
        number = np.bincount(at, minlength=self.grid[0] * self.grid[1])
        total = np.bincount(at, values, len(number))
        return np.where(number > 0, total / np.maximum(number, 1), np.nan).reshape(self.grid)


def tiles_of(mask: NDArray[np.bool_], side: int | None = None) -> TileGrid:
    """Square tiles over the pixels of a mask (h, w), `side` px wide; those that hold few of them are left out."""
    height, width = mask.shape
    side = side or side_of(width)
    grid = -(-height // side), -(-width // side)
    v, u = np.mgrid[0:height, 0:width] // side
    flat = v * grid[1] + u
    counts = np.bincount(flat[mask], minlength=grid[0] * grid[1])
    kept = np.flatnonzero(counts >= max(FULL * side * side, 1))
    number = np.full(grid[0] * grid[1], -1)
    number[kept] = np.arange(len(kept))
    label = np.where(mask, number[flat], -1)
    return TileGrid(label, counts[kept], np.column_stack([kept // grid[1], kept % grid[1]]), grid, side)


def side_of(width: int) -> int:
    """Edge of a tile [px] in an image of this width."""
    return max(1, round(width / ACROSS))
