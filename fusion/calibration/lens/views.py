"""What a camera saw of a board: one view a picture, and the corners of it that can be trusted."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.lens.boards.board import Board
from fusion.geometry.pose import Array

STOOD = 0.01  # of a board's diagonal in the picture: one that shifts by less stood still, or nearly (guess)


@dataclass(frozen=True)
class BoardView:
    """The corners of a board in one picture."""

    name: str  # of the picture
    ids: NDArray[np.intp]  # (n,) index of each corner on the board, row by row
    points: Array  # (n, 3) the same corners on the board [m], z 0
    pixels: Array  # (n, 2) where they were seen [px]
    how: str = ""  # which detector found them

    def __len__(self) -> int:
        return len(self.ids)

    def only(self, keep: NDArray) -> "BoardView":
        """The view with some of its corners: a mask or indices (m,)."""
        return replace(self, ids=self.ids[keep], points=self.points[keep], pixels=self.pixels[keep])


def view_of(name: str, pixels: Array, board: Board, ids: NDArray[np.intp] | None = None, how: str = "") -> BoardView:
    """A view of a board from its corners (n, 2) [px]; without ids, of all corners row by row."""
    ids = np.arange(board.corners) if ids is None else np.asarray(ids, np.intp)
    return BoardView(name, ids, board.points()[ids], np.asarray(pixels, float).reshape(-1, 2), how)


def common(first: BoardView, second: BoardView) -> tuple[BoardView, BoardView]:
    """The corners that two views (of two cameras) share, in the same order."""
    _, one, two = np.intersect1d(first.ids, second.ids, return_indices=True)
    return first.only(one), second.only(two)


def different(views: Sequence[BoardView]) -> list[BoardView]:
    """Those that are no repetition of one before: the corners of a board that stood still shift by noise alone.

    What a lens bends there, and where the detector puts a corner, is then the same in all, and no number of them
    averages it out.
    """
    kept: list[BoardView] = []
    for view in views:
        if not any(_same(view, other) for other in kept):
            kept.append(view)
    return kept


def _same(one: BoardView, other: BoardView) -> bool:
    first, second = common(one, other)
    if len(first) < 4:
        return False
    size = float(np.linalg.norm(np.ptp(first.pixels, axis=0)))
    return bool(np.median(np.linalg.norm(first.pixels - second.pixels, axis=1)) < STOOD * size)


def covered(views: Sequence[BoardView], size: tuple[int, int], cells: int = 8) -> float:
    """Share of the picture's cells (cells x cells) in which at least one corner was seen; size is (width, height)."""
    pixels = np.concatenate([view.pixels for view in views]) if views else np.zeros((0, 2))
    cell = np.floor((pixels + 0.5) / np.array(size) * cells).astype(int).clip(0, cells - 1)
    return len(np.unique(cell, axis=0)) / cells**2
