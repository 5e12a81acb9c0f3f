"""Infrared pictures of the board as a lens draws them: sixteen places per pixel, a little blur, noise."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from tools.sets.fresh.lens import Lens
from tools.sets.fresh.views import Board

Array = NDArray[np.float64]

BLUR = 0.45  # px
PLACES = (-0.375, -0.125, 0.125, 0.375)
CEILING = 60000.0


class Pictures:
    """A camera whose light is `counts` at 1 m, white, on the axis."""

    def __init__(self, lens: Lens, counts: float) -> None:
        self.counts = counts
        self.rays = [lens.rays(du, dv) for dv in PLACES for du in PLACES]

    def of(self, board: Board, rng: np.random.Generator) -> Array:
        """(h, w) counts."""
        total = np.zeros(self.rays[0].shape[:2])
        for ray in self.rays:
            view, length = board.look(ray), np.linalg.norm(ray, axis=-1)
            lit = view.reflectance * view.cosine / (np.where(np.isfinite(view.z), view.z, 1.0) * length) ** 2 / length
            total += self.counts * lit / len(self.rays)
        total = 50 + gaussian_filter(total, BLUR)
        return np.asarray(np.minimum(total + np.sqrt(variance(total)) * rng.standard_normal(total.shape), CEILING))


def variance(counts: Array) -> Array:
    """Of the noise of a picture."""
    return 3 * np.maximum(counts, 0) + 100
