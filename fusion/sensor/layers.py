"""A table over row, column and one more variable, read as a stack of images: as fast as a curve."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

Stack = NDArray[np.float32]


class Layers:
    """A table (rows, columns, n) over its grid, spread over the pixels (height, width) of an image once.

    Attributes:
        nodes: (n,) of the third variable.
    """

    def __init__(self, table: NDArray[np.floating], grid: Sequence[Sequence[float]], shape: tuple[int, int]) -> None:
        rows, columns = (
            np.interp(np.arange(size), axis, np.arange(float(len(axis))))
            for size, axis in zip(shape, grid[:2], strict=True)
        )
        places = np.meshgrid(rows, columns, indexing="ij")
        images = [map_coordinates(layer, places, order=1, mode="nearest") for layer in np.moveaxis(table, -1, 0)]
        self.nodes = np.asarray(grid[2], float)
        self._images = np.stack(images).astype(np.float32).reshape(-1)
        self._pixel = np.arange(shape[0] * shape[1], dtype=np.intp)

    def at(self, values: NDArray[np.floating]) -> Stack:
        """(height, width) read between the two nearest layers, held outside; NaN where the value is."""
        place = np.interp(values.reshape(-1), self.nodes, np.arange(float(len(self.nodes)))).astype(np.float32)
        known = np.isfinite(place)
        below = np.minimum(np.where(known, place, 0).astype(np.intp), max(len(self.nodes) - 2, 0))
        first = below * len(self._pixel) + self._pixel
        second = first + (len(self._pixel) if len(self.nodes) > 1 else 0)
        low = self._images[first]
        return (low + (place - below) * (self._images[second] - low)).reshape(values.shape)


@lru_cache(maxsize=4)
def layers_of(table: bytes, size: tuple[int, int, int], grid: tuple, shape: tuple[int, int]) -> Layers:
    """The layers of a table given by its bytes (float64), kept for the next frame."""
    return Layers(np.frombuffer(table).reshape(size), grid, shape)
