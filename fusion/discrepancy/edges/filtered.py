"""Filtered: what frames show that are filtered each by itself, as the noise of their neighbours says."""

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.sensor.view import Image

REACH = 4.0  # standard deviations of a window, from which on nothing of it is left


def filtered(mean: Image, sigma: Image, window: float) -> tuple[Image, Image]:
    """Mean and spread (h, w) [m] of repeated frames behind a Gaussian window; NaN where neither is known.

    Args:
        window: variance of it along a side [px^2].
    """
    if window <= 0:
        return mean, sigma
    reach = int(np.ceil(REACH * np.sqrt(window)))
    weights = np.exp(-0.5 * np.arange(-reach, reach + 1) ** 2 / window)
    weights /= weights.sum()
    # every pixel of noise counts with its own weight
    return _mean(mean, weights), np.sqrt(_mean(sigma**2, weights**2))


def _mean(image: Image, weights: NDArray[np.float64]) -> Image:
    known = np.isfinite(image)
    parts = (np.where(known, image, 0.0), known / weights.sum() ** 2)
    whole, share = (cv2.sepFilter2D(part.astype(float), -1, weights, weights) for part in parts)
    return np.where(known, whole / np.maximum(share, 1e-9), np.nan)
