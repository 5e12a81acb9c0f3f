"""An image taken apart into what is coarse in it and what is fine, without the background."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

COARSE = 3.0  # [px of the coarse picture] standard deviation; below it print lies, above it light (guess)


@dataclass(frozen=True)
class Bands:
    """An image of the surface: (h, w, 3) float32 each; their sum is the image where the surface is.

    Attributes:
        low: what is coarse; near a rim the mean of what lies on this side of it.
        high: what is fine.
    """

    low: NDArray[np.float32]
    high: NDArray[np.float32]


def bands_of(color: NDArray[np.uint8], front: NDArray[np.float32]) -> Bands:
    """The bands of an image.

    Args:
        color: (h, w, 3) uint8.
        front: (h', w') depth of the surface in a coarser picture of the same camera, infinite where there is none.
    """
    h, w = color.shape[:2]
    low, high = np.zeros((h, w, 3), np.float32), np.zeros((h, w, 3), np.float32)
    known = np.isfinite(front)
    if not known.any():
        return Bands(low, high)
    # a pixel in from the rim: poses are off by about so much
    inner = cv2.erode(known.astype(np.uint8), np.ones((3, 3), np.uint8))
    share = np.asarray(cv2.resize(inner, (w, h), interpolation=cv2.INTER_NEAREST))
    part = _around(known, (h, w))
    weight, picture = share[part].astype(np.float32), color[part].astype(np.float32)
    sigma = COARSE * w / front.shape[1]
    # by boxes, as they cost the same at any width: three of them are a Gaussian to a few percent
    size = 2 * round(sigma) + 1
    both = np.dstack([picture * weight[..., None], weight])
    for _ in range(3):
        both = np.asarray(cv2.blur(both, (size, size)))
    mean = both[..., :3] / np.maximum(both[..., 3:], 1e-3)
    low[part] = np.where(both[..., 3:] > 1e-3, mean, picture)
    high[part] = picture - low[part]
    return Bands(low, high)


def _around(known: NDArray[np.bool_], shape: tuple[int, int]) -> tuple[slice, slice]:
    """Rows and columns of a picture of some shape that hold what is known in a coarser one, and a little more."""
    out = []
    for axis in (0, 1):
        found, share = np.flatnonzero(known.any(axis=1 - axis)), shape[axis] / known.shape[axis]
        out.append(slice(max(int((found[0] - 6) * share), 0), int((found[-1] + 7) * share)))
    return out[0], out[1]
