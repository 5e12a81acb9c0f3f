# mypy: ignore-errors
"""Rough places: where depth scatters about its plane by more than noise does, its error is shared by a whole window.

Matching windows tear steep and strongly bent surfaces into steps, mixed pixels bend what borders on an edge, and both
read nearer or farther by as much on many pixels at a time. Such errors do not average out, but follow the view as the
object turns, and so push the axis (measured on the statue of the open challenges: 0.4 mm).
"""

import numpy as np
from numpy.typing import NDArray

from fusion.compute.arrays import F32_2, F64_2, U8_2
from fusion.compute.language import kernel, ti
from fusion.compute.start import start

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
    start()
    scatter, count = np.full(depth.shape, np.nan), np.ones(depth.shape)
    _scatter(np.ascontiguousarray(depth, np.float32), taken.astype(np.uint8), scatter, count)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = scatter / np.square(sigma, dtype=float)
    known = np.isfinite(ratio)
    excess = np.zeros(depth.shape)
    if known.any():
        typical = max(float(np.median(ratio[known])), 1e-12)
        excess[known] = np.maximum(ratio[known] / typical - 1 - SURE * np.sqrt(2 / count[known]), 0)
    return excess


@kernel
def _scatter(depth: F32_2, taken: U8_2, scatter: F64_2, count: F64_2):
    """Variance [m^2] of the taken depths about their plane, and their number, in the window of each taken pixel; NaN
    where they are too few or lie in a row, through which there is no plane."""
    for v0, u0 in ti.ndrange(depth.shape[0], depth.shape[1]):
        if taken[v0, u0] == 1:
            zero = ti.cast(0.0, ti.f64)
            n, u, v, z, uu, vv, uv, uz, vz, zz = zero, zero, zero, zero, zero, zero, zero, zero, zero, zero
            for j in range(ti.max(v0 - HALF, 0), ti.min(v0 + HALF + 1, depth.shape[0])):
                for i in range(ti.max(u0 - HALF, 0), ti.min(u0 + HALF + 1, depth.shape[1])):
                    if taken[j, i] == 1:
                        x, y = ti.cast(i - u0, ti.f64), ti.cast(j - v0, ti.f64)
                        d = ti.cast(depth[j, i], ti.f64) - depth[v0, u0]
                        n, u, v, z = n + 1, u + x, v + y, z + d
                        uu, vv, uv = uu + x * x, vv + y * y, uv + x * y
                        uz, vz, zz = uz + x * d, vz + y * d, zz + d * d
            u, v, z = u / n, v / n, z / n
            uu, vv, uv = uu / n - u * u, vv / n - v * v, uv / n - u * v
            uz, vz, zz = uz / n - u * z, vz / n - v * z, zz / n - z * z
            area = uu * vv - uv * uv
            if n > 3 and area > 1e-6:
                explained = (uz * (uz * vv - vz * uv) + vz * (vz * uu - uz * uv)) / area
                scatter[v0, u0] = ti.max(zz - explained, 0.0) * n / (n - 3)
                count[v0, u0] = n
