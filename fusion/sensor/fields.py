"""Random fields that are the same every time: what is frozen into a sensor, or into a scene that stands still."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter


@lru_cache(maxsize=16)
def frozen_field(shape: tuple[int, int], width: float, name: str, seed: int) -> NDArray[np.float32]:
    """A field (h, w) with mean 0 and standard deviation 1, smooth over `width` [px]; read only.

    Args:
        width: standard width of the Gaussian that makes neighbours alike; 0 for independent pixels.
        name: of the effect, so that two effects of one sensor differ.
        seed: of the sensor or of the placement.
    """
    rng = np.random.default_rng([seed, *name.encode()])
    field = correlated(rng, shape, width)
    field.flags.writeable = False
    return field


def correlated(rng: np.random.Generator, shape: tuple[int, ...], width: float) -> NDArray[np.float32]:
    """Normal numbers (h, w) with standard deviation 1, smoothed over `width` [px]; the image's sides are joined."""
    white = rng.standard_normal(shape, dtype=np.float32)
    if width <= 0:
        return white
    return gaussian_filter(white, width, mode="wrap") / _smoothed_spread(shape, width)


@lru_cache(maxsize=16)
def _smoothed_spread(shape: tuple[int, ...], width: float) -> float:
    """Standard deviation of white noise after the smoothing: the root of the kernel's energy."""
    impulse = np.zeros(shape)
    impulse[tuple(n // 2 for n in shape)] = 1.0
    return float(np.sqrt((gaussian_filter(impulse, width, mode="wrap") ** 2).sum()))


@lru_cache(maxsize=16)
def frozen_map(shape: tuple[int, int], width: float, name: str, seed: int) -> NDArray[np.float32]:
    """A frozen field (h, w) whose own mean over the image is 0 and whose own root mean square is 1; read only."""
    field = frozen_field(shape, width, name, seed)
    field = field - field.mean()
    field /= np.sqrt(np.mean(field**2))
    field.flags.writeable = False
    return field
