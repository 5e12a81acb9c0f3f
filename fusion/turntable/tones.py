"""What is printed on a surface, whatever light falls on it: contrast with the surroundings in the image."""

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
    return contrast_of(brightness(color), shown)


def contrast_of(gray: Image, shown: NDArray[np.bool_]) -> Image:
    """`contrast` of a brightness (h, w) [counts]."""
    weight = shown.astype(np.float32)

    def mean(sigma: float) -> tuple[Image, Image]:
        share = np.asarray(cv2.GaussianBlur(weight, (0, 0), sigma), np.float32)
        total = np.asarray(cv2.GaussianBlur(gray * weight, (0, 0), sigma), np.float32)
        return np.asarray(total / np.maximum(share, 1e-6), np.float32), share

    (fine, _), (wide, share) = mean(SOFT), mean(AROUND)
    return np.where(shown & (share > LEAST), (fine - wide) / (wide + DARK), np.nan).astype(np.float32)
