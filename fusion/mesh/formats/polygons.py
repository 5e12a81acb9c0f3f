"""Polygons become triangles."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray


def triangles(polygons: Iterable[NDArray[np.integer]]) -> NDArray[np.int64]:
    """(m, 3) corners of groups of polygons, each (k, n) with n corners: a fan about the first of each.

    Raises:
        ValueError: fewer than three corners.
    """
    found = [np.zeros((0, 3), np.int64)]
    for group in polygons:
        count = group.shape[1]
        if count < 3:
            raise ValueError(f"a face of {count} corner{'s' * (count != 1)}")
        first = np.repeat(group[:, :1], count - 2, axis=1)
        found.append(np.stack([first, group[:, 1:-1], group[:, 2:]], axis=2).reshape(-1, 3).astype(np.int64))
    return np.concatenate(found)
