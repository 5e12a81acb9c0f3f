"""A table of any number of variables, read between its entries."""

from collections.abc import Sequence
from itertools import product

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
    nodes = [(np.asarray(values), np.asarray(x)) for values, x in zip(grid, at, strict=True)]
    if len(nodes) == 1:
        return np.interp(nodes[0][1], nodes[0][0], table)
    places = [np.interp(x, values, np.arange(float(len(values)))) for values, x in nodes]
    # the lower neighbour; a NaN goes on in the share between the neighbours
    low = [np.nan_to_num(place).astype(np.intp) for place in places]
    share = [place - index for place, index in zip(places, low, strict=True)]
    total: NDArray[np.floating] = np.zeros(())
    for corner in product((0, 1), repeat=len(nodes)):
        weight: NDArray[np.floating] = np.ones(())
        flat: NDArray[np.integer] = np.zeros((), np.intp)
        for upper, index, part, size in zip(corner, low, share, table.shape, strict=True):
            weight = weight * (part if upper else 1 - part)
            flat = flat * size + np.minimum(index + upper, size - 1)
        total = total + weight * table.ravel()[flat]
    return total
