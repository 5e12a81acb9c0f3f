"""How far tiles may be off for reasons that are no discrepancy: noise, speckle, poses, the shape of the target."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpstrf
from scipy.spatial.distance import cdist

Matrix = NDArray[np.float64]

# lengths over which a real surface may leave its mesh [m]: guess, from a dent to the bow of a wall
BOWS_M = (0.1, 0.4, 1.2)
BENDS_M = BOWS_M[1:]  # of them, what is told from tiles that scatter: each has a size of its own where none is stated
# of the image width, over which an error changes that recordings have for themselves: guess, a spot to half the image
DRIFTS = (0.15, 0.5)
SMOOTH = 2.0  # squares over which it changes at least: what changes faster is each square's own
SLIGHT = 1e-4  # of a shape's variance: how far each point may stay from it where only its size is asked
FAINT = 1e-3  # of the largest direction of such a field: what is left out is no hundredth of it


def grain(cell: NDArray[np.intp], other: NDArray[np.intp], side: int, window_px: float) -> Matrix:
    """Correlation (n, m) of the means over squares of a field whose pixels share a window of `window_px`.

    Pixels d apart correlate with 1 - d / window in each direction. Diagonal: variance of a square's mean over that of
    a pixel.
    """
    steps = np.abs(cell[:, None, :] - other[None, :, :])
    along = _between(side, int(steps.max(initial=0)), window_px)
    return along[steps[..., 0]] * along[steps[..., 1]]


def neighbours(alike: Matrix, side: int) -> float:
    """By how much (at least 1) the mean of a square varies more than that of as many independent pixels.

    Args:
        alike: (2, k) correlation of pixels 0, 1, ... apart along u and along v.
    """
    apart = np.arange(1, min(alike.shape[1], side))
    along = 1.0 + 2.0 * (alike[:, apart] * (1.0 - apart / side)).sum(axis=1)
    return max(1.0, float(np.prod(np.maximum(along, 0.0))))


def bow(points: Matrix, others: Matrix, sigma_m: float) -> Matrix:
    """Covariance (n, m) [m^2] of a smooth unknown shape between surface points (n, 3) and (m, 3) [m]."""
    return np.asarray(sigma_m**2 * np.mean([bend(points, others, length) for length in BOWS_M], axis=0))


def bend(points: Matrix, others: Matrix, length_m: float) -> Matrix:
    """Covariance (n, m) of a shape of unit size that changes over one length, between (n, 3) and (m, 3) points [m]."""
    return np.asarray(np.exp(-0.5 / length_m**2 * cdist(points, others, "sqeuclidean")))


def bending(points: Matrix, length_m: float) -> Matrix:
    """(n, k) columns of which the products sum up to `bend` among surface points (n, 3) [m]."""
    lower, order, rank, _ = dpstrf(bend(points, points, length_m), tol=SLIGHT, lower=1)
    out = np.zeros((len(points), rank))
    out[order - 1] = np.tril(lower)[:, :rank]
    return out


def drifting(at: Matrix, side: float, width: float) -> Matrix:
    """(n, k) columns of which the products sum up to the covariance of a smooth field of unit spread.

    Args:
        at: (n, 2) places of squares in the image [px]; equal places have one value.
        side, width: of the squares and of the image [px].
    """
    places, number = np.unique(at, axis=0, return_inverse=True)
    apart = 3.0**0.5 * cdist(places, places)
    lengths = [max(share * width, SMOOTH * side) for share in DRIFTS]
    # Matern, 3/2: once differentiable, as what nobody knows should be; Gaussian bells would foresee all of its bends
    field = np.mean([(1.0 + apart / length) * np.exp(-apart / length) for length in lengths], axis=0)
    values, vectors = np.linalg.eigh(field)
    kept = values > FAINT * values[-1]
    return np.asarray((vectors[:, kept] * np.sqrt(values[kept]))[number.ravel()])


def _between(side: int, most: int, window: float) -> NDArray[np.float64]:
    """(most + 1,) mean correlation along one direction between the pixels of squares 0, 1, ... squares apart."""
    by = np.arange(1 - side, side)  # of a pixel's place in its square, in as many pairs
    apart = np.abs(side * np.arange(most + 1)[:, None] + by)
    return np.asarray(np.maximum(1.0 - apart / max(window, 1.0), 0.0) @ (side - np.abs(by))) / side**2
