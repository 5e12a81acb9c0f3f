"""Rough places: where depth scatters about its plane by more than noise does, its error is shared by a whole window.

Matching windows tear steep and strongly bent surfaces into steps, mixed pixels bend what borders on an edge, and both
read nearer or farther by as much on many pixels at a time. Such errors do not average out, but follow the view as the
object turns, and so push the axis (measured on the statue of the open challenges: 0.4 mm).
"""

import cv2
import numpy as np
from numpy.typing import NDArray

HALF = 3  # [px] of the window: a matching window and its surroundings (guess: with 2, steps are taken for slopes)
SURE = 2.0  # standard deviations of the scatter that noise alone leaves

Array = NDArray[np.float64]


def shared_errors(depth: NDArray[np.float32], sigma: NDArray[np.float32], taken: NDArray[np.bool_]) -> Array:
    """Variance (h, w) of the error that a pixel shares with its window, over that of the noise; 0 in smooth places.

    The noise is what half of the pixels do not exceed, so a sigma that is wrong as a whole changes nothing.

    Args:
        depth, sigma: (h, w) [m].
        taken: (h, w) pixels of the surface; others say nothing.
    """
    whole = np.zeros(depth.shape)
    if not taken.any():
        return whole
    # the rest of the image says nothing
    part = tuple(slice(int(np.min(i)), int(np.max(i)) + 1) for i in np.nonzero(taken))
    whole[part] = _in_part(depth[part], sigma[part], taken[part])
    return whole


def _in_part(depth: NDArray[np.float32], sigma: NDArray[np.float32], taken: NDArray[np.bool_]) -> Array:
    scatter, count = _scatter(np.where(taken, depth, 0).astype(float), taken)
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = scatter / sigma.astype(float) ** 2
    known = taken & np.isfinite(ratio) & (count > 3)
    if not known.any():
        return np.zeros(depth.shape)
    typical = max(float(np.median(ratio[known])), 1e-12)
    excess = ratio / typical - 1 - SURE * np.sqrt(2 / np.maximum(count, 1))
    return np.where(known, np.maximum(excess, 0), 0)


def _scatter(depth: Array, taken: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Variance (h, w) [m^2] of the taken depths about their plane, and their number, in the window of each pixel."""
    v, u = np.indices(depth.shape, float)
    weight = taken.astype(float)
    count = np.maximum(_sum(weight), 1)

    def mean(values: Array) -> Array:
        return np.asarray(_sum(weight * values) / count)

    z0 = float(depth[taken].mean())  # keeps digits
    z = depth - z0
    mu, mv, mz = mean(u), mean(v), mean(z)
    uu, vv, uv = mean(u * u) - mu**2, mean(v * v) - mv**2, mean(u * v) - mu * mv
    uz, vz, zz = mean(u * z) - mu * mz, mean(v * z) - mv * mz, mean(z * z) - mz**2
    area = uu * vv - uv**2
    with np.errstate(invalid="ignore", divide="ignore"):
        explained = (uz * (uz * vv - vz * uv) + vz * (vz * uu - uz * uv)) / area
    left = np.where(area > 1e-6, zz - explained, np.nan)  # nothing lies about a plane through a row of pixels
    return np.maximum(left, 0) * count / np.maximum(count - 3, 1), count


def _sum(values: Array) -> Array:
    size = (2 * HALF + 1, 2 * HALF + 1)
    return np.asarray(cv2.boxFilter(values, -1, size, normalize=False, borderType=cv2.BORDER_CONSTANT))
