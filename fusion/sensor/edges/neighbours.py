"""Neighbouring pixels that may see two surfaces: found in few passes over the image, so that the rest looks at few."""

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.view import Image

Indices = NDArray[np.intp]


def steps_along(depth: Image, axis: int, share: float) -> Indices:
    """Flat indices (n,) of the pixels of an image (h, w) [m] whose neighbour below (axis 0) or to the right (axis 1) is
    nearer or farther by more than a share of the nearer depth, or by up to a hundredth less: rounding hides none.
    """
    z, beyond = depth.reshape(-1), depth.reshape(-1) * (1 + 0.99 * share)
    stride = stride_along(depth, axis)
    # of NaN it is not true
    return pairs_along(depth, axis, (z[stride:] > beyond[:-stride]) | (z[:-stride] > beyond[stride:]))


def pairs_along(depth: Image, axis: int, true: NDArray[np.bool_]) -> Indices:
    """Flat indices (n,) of the pixels for which something is true of them and the next one along an axis.

    Args:
        true: (h w - stride,) in flat order.
    """
    at = np.flatnonzero(true)  # ten times as fast as np.nonzero of an image
    # the end of a row is no neighbour of the next one's start
    return at if axis == 0 else at[at % depth.shape[1] < depth.shape[1] - 1]


def stride_along(depth: Image, axis: int) -> int:
    """From a pixel to the one below (axis 0) or to the right (axis 1), in flat order."""
    return depth.shape[1] if axis == 0 else 1
