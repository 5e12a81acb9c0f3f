"""How far tiles may be off for reasons that are no discrepancy: noise, speckle, poses, the shape of the target."""

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]

# lengths over which a real surface may leave its mesh [m]: guess, from a dent to the bow of a wall
BOWS_M = (0.1, 0.4, 1.2)


def grain(cell: NDArray[np.intp], other: NDArray[np.intp], side: int, window_px: float) -> Matrix:
    """Correlation (n, m) of the means over squares of a field whose pixels share a window of `window_px`.

    Pixels d apart correlate with 1 - d / window in each direction. Diagonal: variance of a square's mean over that of
    a pixel.
    """
    reach = int(max(np.abs(cell[:, None] - other[None]).max(initial=0), 1))
    along = np.array([_between(side, k, window_px) for k in range(reach + 1)])
    steps = np.abs(cell[:, None, :] - other[None, :, :])
    return along[steps[..., 0]] * along[steps[..., 1]]


def bow(points: Matrix, others: Matrix, sigma_m: float) -> Matrix:
    """Covariance (n, m) [m^2] of a smooth unknown shape between surface points (n, 3) and (m, 3) [m]."""
    apart = ((points[:, None] - others[None]) ** 2).sum(axis=-1)
    return np.asarray(sigma_m**2 * np.mean([np.exp(-0.5 * apart / length**2) for length in BOWS_M], axis=0))


def _between(side: int, steps: int, window: float) -> float:
    """Mean correlation along one direction between the pixels of two squares, `steps` squares apart."""
    i = np.arange(side)
    apart = np.abs(i[:, None] - i[None] + steps * side)
    return float(np.maximum(1.0 - apart / max(window, 1.0), 0.0).mean())
