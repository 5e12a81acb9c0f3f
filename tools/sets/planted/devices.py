"""What two kinds of camera make of the true depth: triangulated disparities, and time of flight along the ray.

Magnitudes: Nguyen, Izadi and Lovell 2012 (1.5 mm at 0.8 m, 6 mm at 2 m: 0.1 px of disparity with f b = 43.5 px m) for
triangulation; a Kinect v2's indoor spread (about 1 mm at 0.8 m) for time of flight.
Rounding: 1/8 px of disparity; files hold millimetres.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, maximum_filter, minimum_filter

from tools.sets.planted.shapes import Array, Rng
from tools.sets.planted.stage import Hits, Pinhole

JUMP = 0.02  # [m] between neighbours that is an edge
GRAZING = np.cos(np.deg2rad(82))  # beyond it no light comes back (guess)


@dataclass(frozen=True)
class Matching:
    """Structured light, the projector on the left; px are of the camera's image.

    Attributes:
        noise: of the disparity [px], shared by neighbours within about `shared` px (the matching window).
        jitter: of where a pixel looks [px]; shows at edges (Nguyen: 0.8 px; rounded to whole pixels here).
    """

    camera: Pinhole
    baseline: float = 0.075
    noise: float = 0.08
    shared: float = 1.2
    step: float = 0.125
    jitter: float = 0.5
    principle = "structured_light"

    def depth(self, hits: Hits, bend: Array | float, rng: Rng) -> Array:
        """(h, w) depth [m], 0 where there is none; `bend` [px] is added to the disparity."""
        h, w = hits.z.shape
        v, u = np.mgrid[:h, :w]
        du, dv = np.rint(self.jitter * rng.standard_normal((2, h, w))).astype(int)
        at = (v + dv).clip(0, h - 1), (u + du).clip(0, w - 1)
        fb = self.camera.f * self.baseline
        true = fb / hits.z
        lost = ~np.isfinite(hits.z) | (hits.cosine < GRAZING) | self.shaded(true)
        grains = gaussian_filter(rng.standard_normal((h, w)), self.shared) * (2 * np.sqrt(np.pi) * self.shared)
        d = np.round((true[at] + bend + self.noise * grains) / self.step) * self.step
        z = fb / np.maximum(d, self.step)
        return np.where(lost | lost[at] | (z > 4.0) | (z < 0.4), 0.0, z)

    def shaded(self, disparity: Array) -> NDArray[np.bool_]:
        """Where the projector does not shine: a point's column in the projector is u + d; a nearer one holds it."""
        column = np.arange(disparity.shape[1]) + disparity
        return np.asarray(column < np.maximum.accumulate(column, axis=1) - 0.5)


@dataclass(frozen=True)
class Flight:
    """Time of flight: noise of the range that grows as its square, mixed pixels at edges."""

    camera: Pinhole
    noise: float = 0.001  # [m] at 0.8 m, frontal
    dropped: float = 0.5  # share of mixed pixels that the maker's filter takes away (guess)
    principle = "itof"

    def depth(self, hits: Hits, bend: Array | float, rng: Rng) -> Array:
        """(h, w) depth [m], 0 where there is none; `bend` [m] is added to the range."""
        z = np.where(np.isfinite(hits.z), hits.z, 8.0)
        near, far = minimum_filter(z, 3), maximum_filter(z, 3)
        edge = far - near > JUMP * np.maximum(1, z / np.maximum(hits.cosine, 0.1) / 2)
        share = rng.beta(0.4, 0.4, z.shape)
        mixed = np.where(edge, share * near + (1 - share) * far, z)
        long = np.linalg.norm(self.camera.rays, axis=-1)
        spread = self.noise * (mixed * long / 0.8) ** 2 / np.sqrt(np.maximum(hits.cosine, 0.1))
        out = np.asarray(mixed + (spread * rng.standard_normal(z.shape) + bend) / long)
        lost = ~np.isfinite(hits.z) | (hits.cosine < GRAZING) | (edge & (rng.random(z.shape) < self.dropped))
        return np.where(lost | (out > 4.5) | (out < 0.4), 0.0, out)


Device = Matching | Flight

# a Kinect's whole image, and its half size, in whose pixels noise and rounding are half as large; the narrow field of
# an Azure Kinect, binned
DEVICES: dict[str, Device] = {
    "matching": Matching(Pinhole(640, 480, 575.0, 319.5, 239.5)),
    "matching-half": Matching(Pinhole(320, 240, 287.5, 159.5, 119.5), noise=0.04, shared=0.8, step=0.0625),
    "flight": Flight(Pinhole(320, 288, 252.0, 159.5, 143.5)),
}
