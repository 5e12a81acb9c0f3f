"""Random fields that are the same every time: what is frozen into a sensor, or into a scene that stands still."""

from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray


@lru_cache(maxsize=16)
def frozen_field(
    shape: tuple[int, int], width: float, name: str, seed: int, window: bool = False
) -> NDArray[np.float32]:
    """A field (h, w) with mean 0 and standard deviation 1, smooth over `width` [px]; read only.

    Args:
        width: standard width of the Gaussian that makes neighbours alike, or side of the window; 0 for independent
            pixels.
        window: neighbours share a square window, as matching does.
        name: of the effect, so that two effects of one sensor differ.
        seed: of the sensor or of the placement.
    """
    rng = np.random.default_rng([seed, *name.encode()])
    field = (windowed if window else correlated)(rng, shape, width)
    field.flags.writeable = False
    return field


def correlated(rng: np.random.Generator, shape: tuple[int, ...], width: float) -> NDArray[np.float32]:
    """Normal numbers (h, w) with standard deviation 1 everywhere, smoothed over `width` [px]."""
    if width <= 0:
        return rng.standard_normal(shape, dtype=np.float32)
    return _filtered(rng, shape, cv2.getGaussianKernel(2 * int(np.ceil(4 * width)) + 1, width, cv2.CV_32F))


def windowed(rng: np.random.Generator, shape: tuple[int, ...], side: float) -> NDArray[np.float32]:
    """Normal numbers (h, w) with standard deviation 1, means over a window of `side` [px]: what matching does.

    Pixels d apart correlate with 1 - d / side in each direction.
    """
    if side <= 1:
        return rng.standard_normal(shape, dtype=np.float32)
    kernel = np.ones((int(np.ceil(side)), 1), np.float32)
    kernel[-1] = side - len(kernel) + 1  # the last pixel belongs to the window in part
    return _filtered(rng, shape, kernel)


def _filtered(rng: np.random.Generator, shape: tuple[int, ...], kernel: NDArray[Any]) -> NDArray[np.float32]:
    """White noise through a kernel (k, 1) in both directions, with standard deviation 1."""
    # a root of the kernel's energy in each direction gives the spread back
    kernel = np.asarray(kernel / np.sqrt((kernel**2).sum()), np.float32)
    reach = len(kernel) // 2
    # a border of its own on each side, cut off again: pixels at the rim are like all others
    white = rng.standard_normal((shape[0] + 2 * reach, shape[1] + 2 * reach), dtype=np.float32)
    return np.asarray(cv2.sepFilter2D(white, -1, kernel, kernel), np.float32)[reach:-reach, reach:-reach]


@lru_cache(maxsize=16)
def frozen_map(shape: tuple[int, int], width: float, name: str, seed: int) -> NDArray[np.float32]:
    """A frozen field (h, w) whose own mean over the image is 0 and whose own root mean square is 1; read only."""
    field = frozen_field(shape, width, name, seed)
    field = field - field.mean()
    field /= np.sqrt(np.mean(field**2))
    field.flags.writeable = False
    return field
