"""What is printed on a surface, whatever light falls on it: contrast with the surroundings in the image."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

AROUND = 12.0  # [px] standard deviation of the surroundings: print is finer, shading wider (guess)
SOFT = 1.0  # [px] by which noise of single pixels is smoothed
DARK = 8.0  # [counts] added to the mean, below which contrast is noise
LEAST = 0.12  # share of the surroundings that must be surface

Image = NDArray[np.float32]


def brightness(color: NDArray[np.uint8]) -> Image:
    """(h, w) of a colour image (h, w, 3) RGB [counts]."""
    return cv2.cvtColor(np.ascontiguousarray(color), cv2.COLOR_RGB2GRAY).astype(np.float32)


def contrast(color: NDArray[np.uint8], shown: NDArray[np.bool_]) -> Image:
    """(brightness - mean) / mean of the surroundings on the same surface, (h, w); NaN off the surface.

    Exposure and white balance cancel, and so does the light that changes slowly over the surface as it turns.

    Args:
        color: (h, w, 3) RGB.
        shown: (h, w) the surface.
    """
    return contrasts_of([brightness(color)], shown)[0]


def contrasts_of(grays: Sequence[Image], shown: NDArray[np.bool_]) -> list[Image]:
    """`contrast` of each of some brightnesses (h, w) [counts] of one surface."""
    weight = shown.astype(np.float32)
    fine, wide = (np.asarray(cv2.GaussianBlur(weight, (0, 0), sigma), np.float32) for sigma in (SOFT, AROUND))
    known = shown & (wide > LEAST)

    def mean(gray: Image, share: Image, sigma: float) -> Image:
        total = np.asarray(cv2.GaussianBlur(gray * weight, (0, 0), sigma), np.float32)
        return np.asarray(total / np.maximum(share, 1e-6), np.float32)

    found = []
    for gray in grays:
        here, around = mean(gray, fine, SOFT), mean(gray, wide, AROUND)
        found.append(np.where(known, (here - around) / (around + DARK), np.nan).astype(np.float32))
    return found
