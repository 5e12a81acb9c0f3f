"""A table over row, column and one more variable, read as a stack of images: as fast as a curve."""

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]
Whole = NDArray[np.intp]
SAME = 1e-6  # share: a float32 cannot tell less
ROUNDS = 6  # a correction rarely leads out of the layers between which a value lies, and hardly ever twice


class Layers:
    """A table (rows, columns, n) over its grid, spread over the pixels (height, width) of an image once.

    Along the third variable each pixel has n + 1 straight pieces; the first and the last, outside, are flat.

    Attributes:
        nodes: (n,) of the third variable.
    """

    def __init__(self, table: Array, grid: Sequence[Sequence[float]], shape: tuple[int, int]) -> None:
        from scipy.ndimage import map_coordinates

        rows, columns = (
            np.interp(np.arange(size), axis, np.arange(float(len(axis))))
            for size, axis in zip(shape, grid[:2], strict=True)
        )
        places = np.meshgrid(rows, columns, indexing="ij")
        images = [map_coordinates(layer, places, order=1, mode="nearest") for layer in np.moveaxis(table, -1, 0)]
        self.nodes = np.asarray(grid[2], float)
        self._images = np.stack([images[0], *images, images[-1]]).astype(np.float32).reshape(-1)
        self._pixel = np.arange(shape[0] * shape[1], dtype=np.intp)
        self._begin = np.concatenate([self.nodes[:1], self.nodes])
        self._per_unit = np.concatenate([[0.0], 1 / np.diff(self.nodes), [0.0]])
        self._edges = np.concatenate([[-np.inf], self.nodes, [np.inf]])

    def at(self, values: Array) -> Array:
        """(height, width) read between the two nearest layers, held outside; NaN where the value is."""
        x = values.reshape(-1)
        low, rise, begin = self._pieces(self._piece(x), self._pixel, x.dtype)
        return np.asarray(low + (x - begin) * rise, np.float32).reshape(values.shape)

    def solved(self, measured: Array, solution: Callable[[Array, Array, Array, Whole], Array]) -> Array | None:
        """(height, width) the values at which an equation holds that has the layers in it; None if that never settles.

        Args:
            measured: (height, width), near the values looked for.
            solution: (value at 0, rise per unit, measured, pixel), each (m,), to the solution on that straight piece.
        """
        known = measured.reshape(-1)
        whole, edges = known.copy(), self._edges.astype(known.dtype)
        pixel, start = self._pixel, known
        for _ in range(ROUNDS):
            piece = self._piece(start)
            low, rise, begin = self._pieces(piece, pixel, known.dtype)
            found = solution(low - begin * rise, rise, start if start is known else known[pixel], pixel)
            whole[pixel] = found
            near = SAME * found  # a solution on an edge belongs to both pieces
            out = (found < edges[piece] - near) | (found > edges[piece + 1] + near)
            if not out.any():
                return whole.reshape(measured.shape)
            pixel, start = pixel[out], found[out]
        return None

    def _piece(self, x: Array) -> Whole:
        return np.searchsorted(self.nodes.astype(x.dtype), x, side="right")

    def _pieces(self, piece: Whole, pixel: Whole, dtype: np.dtype) -> tuple[Array, Array, Array]:
        """Value at the begin of each piece, rise per unit, and where it begins, each (m,)."""
        first = piece * len(self._pixel) + pixel
        low = self._images[first]
        rise = (self._images[first + len(self._pixel)] - low) * self._per_unit.astype(dtype)[piece]
        return low, rise, self._begin.astype(dtype)[piece]


@lru_cache(maxsize=4)
def layers_of(table: bytes, size: tuple[int, int, int], grid: tuple, shape: tuple[int, int]) -> Layers:
    """The layers of a table given by its bytes (float64), kept for the next frame."""
    return Layers(np.frombuffer(table).reshape(size), grid, shape)
