"""Print on surfaces: a mosaic whose cells are coloured by a hash of their place, so nothing repeats."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rng = np.random.Generator

PAPER = ((206, 200, 186), (196, 192, 182), (214, 206, 196))
POSTER = ((200, 52, 44), (236, 196, 70), (44, 96, 170), (240, 236, 224), (36, 38, 46), (80, 150, 96))
WOOD = ((150, 112, 74), (164, 124, 84), (138, 102, 66))
WHITE = ((222, 222, 218), (212, 212, 210))
CLOTH = ((70, 84, 120), (88, 100, 136), (60, 66, 92), (110, 112, 140))
GREEN = ((62, 110, 58), (84, 136, 70), (50, 88, 50))
TILES = ((120, 104, 92), (138, 122, 108), (108, 92, 82))
SCREEN = ((18, 18, 22), (22, 22, 26))


@dataclass(frozen=True)
class Print:
    """Colours of points of a surface.

    Attributes:
        palette: colours (k, 3), 0 to 255.
        cell: edge [m] of the coarse cells; finer ones of a third of it lie upon them.
        contrast: of the finer cells, share of the brightness.
        key: which of all mosaics with these cells.
        turn: (3, 3), how the cells lie in space: edges along no wall.
    """

    palette: Array
    cell: float
    contrast: float
    key: int
    turn: Array

    def at(self, points: Array) -> Array:
        """(n, 3) of points (n, 3) [m]."""
        turned = points @ self.turn
        coarse = cells(turned, self.cell, self.key)
        fine = cells(turned, self.cell / 3, self.key + 1)
        shade = 1 + self.contrast * ((fine % 1024) / 511.5 - 1)
        return np.asarray(self.palette[coarse % len(self.palette)] * shade[:, None])


def cells(points: Array, size: float, key: int) -> NDArray[np.uint32]:
    """(n,) a number for each cube of edge `size` in which points (n, 3) lie; neighbours have nothing in common."""
    corner = np.floor(points / size).astype(np.int32).view(np.uint32)
    mixed = np.full(len(points), key * 2654435761 % 2**32, np.uint32)
    for axis, prime in enumerate((73856093, 19349663, 83492791)):  # Teschner et al. 2003, spatial hashing
        mixed = (mixed ^ (corner[:, axis] * np.uint32(prime))) * np.uint32(2246822519)
        mixed ^= mixed >> np.uint32(15)
    return np.asarray(mixed >> np.uint32(4))


def printed(rng: Rng, palette: tuple[tuple[int, int, int], ...], cell: float, contrast: float = 0.25) -> Print:
    """A print of its own."""
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    return Print(np.array(palette, float), cell, contrast, int(rng.integers(1, 2**31)), turn)
