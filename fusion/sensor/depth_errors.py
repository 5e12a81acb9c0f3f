"""What a calibration leaves of errors of depth: how its numbers hold each other, as what they do to the depth."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fusion.sensor.laws.table import interpolated

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class DepthErrors:
    """Independent errors of depth, each of one standard deviation, over the image and the distance.

    The covariance of the depth at any two places is the sum over the errors of what each does at both: numbers of one
    law that are known badly alone and well together need no list of correlations.
    """

    # v, u, depth: rows and columns [px], depths [m] of the grid, increasing
    v: Array
    u: Array
    depth: Array
    fields: Array  # (r, v, u, depth) what each of r errors does to the depth there [m]

    def at(self, u: ArrayLike, v: ArrayLike, depth: ArrayLike) -> Array:
        """What each error does (r, ...) [m] at pixels and depths; held beyond the grid."""
        grid = (tuple(self.v), tuple(self.u), tuple(self.depth))
        return np.array([interpolated(field, grid, (v, u, depth)) for field in self.fields])
