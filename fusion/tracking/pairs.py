"""Point-to-plane pairs of sampled points with a model, one by one, and how much each counts."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.depth import PointMap
from fusion.geometry.robust import robust_std
from fusion.tracking.association import IN_FRONT, associate

Array = NDArray[np.float64]
# errors of neighbouring pixels are alike (filters, matching windows, fixed patterns): what one independent
# equation is worth, a guess until a recording's own noise correlation is measured
EFFECTIVE = 0.005
CUT = 4.685  # of Tukey's biweight (Holland and Welsch 1977)


@dataclass(frozen=True)
class Pairs:
    """Point-to-plane pairs: r = n . (moved - q), and how the association went.

    Attributes:
        index: (m,) positions in the source arrays.
        moved, normals: (m, 3) in the model's camera.
        pixel: (m,) flat model pixel.
        residual: (m,) [m].
        sigma: (m,) standard deviation of the residual [m].
        visible: number of source points that the model could have met.
        violating: number of source points where the model's camera looked through them.
    """

    index: NDArray[np.int64]
    moved: Array
    normals: Array
    pixel: NDArray[np.int32]
    residual: Array
    sigma: Array
    visible: int
    violating: int


def find_pairs(
    sampled: tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]],
    T_model_source: Array,
    model: PointMap,
    reach: float,
    min_cosine: float = 0.7,
) -> Pairs:
    """Pair points (n, 3) with normals (n, 3) and sigma (n,) with the model at a pose."""
    points, normals, sigma = sampled
    pixel, moved = associate(points, normals, T_model_source, model, reach, min_cosine)
    index = np.flatnonzero(pixel >= 0)
    chosen = pixel[index]
    n = model.normals.reshape(-1, 3)[chosen].astype(float)
    q = model.points.reshape(-1, 3)[chosen].astype(float)
    p = moved[index].astype(float)
    model_sigma = model.sigma.reshape(-1)[chosen]
    # depth noise acts along the line of sight: seen along the normal it shrinks by the cosine
    cosine = np.abs(np.einsum("ij,ij->i", n, q)) / np.linalg.norm(q, axis=1)
    spread = cosine * np.sqrt(sigma[index].astype(float) ** 2 + np.nan_to_num(model_sigma.astype(float)) ** 2)
    residual = np.einsum("ij,ij->i", n, p - q)
    violating = int((pixel == IN_FRONT).sum())
    visible = len(index) + int((pixel <= IN_FRONT).sum())
    return Pairs(index, p, n, chosen, residual, np.maximum(spread, 1e-5), visible, violating)


def tukey(standardised: Array, cut: float = CUT) -> Array:
    """Tukey's biweight of residuals in units of their scale (Holland and Welsch 1977): 0 beyond the cut."""
    inside = np.clip(1 - (standardised / cut) ** 2, 0, None)
    return inside**2


def robust_scale(residual: Array, sigma: Array) -> float:
    """Ratio of the observed spread to the declared one, from the median; at least 1."""
    if len(residual) == 0:
        return 1.0
    return max(1.0, robust_std(residual / sigma))
