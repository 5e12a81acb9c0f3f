"""A table of any number of variables, read between its entries."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray


def interpolated(
    table: NDArray[np.floating], grid: Sequence[Sequence[float]], at: Sequence[ArrayLike]
) -> NDArray[np.floating]:
    """Multilinear interpolation; beyond its borders the table is held. NaN where a variable is NaN.

    Args:
        table: (n1, n2, ...) values.
        grid: increasing values of each variable, n1, n2, ... of them.
        at: each variable, as arrays that broadcast to the shape of the result.
    """
    if len(grid) == 1:
        return np.interp(np.asarray(at[0]), grid[0], table)
    from scipy.ndimage import map_coordinates

    # in counts of entries, held at the borders
    places = [np.interp(np.asarray(x), nodes, np.arange(float(len(nodes)))) for nodes, x in zip(grid, at, strict=True)]
    together = np.stack(np.broadcast_arrays(*places))
    known = np.isfinite(together).all(axis=0)
    # one place alone is no array: time and temperature are single numbers for a whole image
    flat = np.where(known, together, 0.0).reshape(len(places), -1)
    values = map_coordinates(table, flat, order=1, mode="nearest", output=float).reshape(known.shape)
    return np.where(known, values, np.nan)
