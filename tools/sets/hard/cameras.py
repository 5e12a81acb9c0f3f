"""What four cameras make of true depth and colours.

Stereo (a D415): disparities that share a matching window, read to 0.09 px, holes where the light grazes, and the
maker's spatial filter (Gastal and Oliveira's domain transform along rows and columns, weight 0.5, edges of 1 px of
disparity) in half of the units. Structured light and time of flight as in tools/sets/planted/devices.py, whose
magnitudes are named there.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from tools.sets.hard.stage import Seen
from tools.sets.planted.devices import DEVICES, GRAZING, Flight, Matching
from tools.sets.planted.shapes import Array, Rng
from tools.sets.planted.stage import Hits, Pinhole


@dataclass(frozen=True)
class Stereo:
    """Two imagers with a projector; noise [px of disparity] shared within `shared` px."""

    camera: Pinhole
    baseline: float = 0.055
    noise: float = 0.07
    shared: float = 2.0
    step: float = 1 / 32
    filtered: bool = False
    principle = "active_stereo"

    def depth(self, hits: Hits, bend: float, rng: Rng) -> Array:
        """(h, w) depth [m], 0 where there is none; `bend` [px] is added to the disparity."""
        fb = self.camera.f * self.baseline
        true = np.where(np.isfinite(hits.z), fb / hits.z, 0.0)
        grains = gaussian_filter(rng.standard_normal(true.shape), self.shared) * (2 * np.sqrt(np.pi) * self.shared)
        lost = (true == 0) | (hits.cosine < GRAZING) | shaded(true)
        lost |= gaussian_filter(rng.standard_normal(true.shape), 3.0) * 6 * np.sqrt(np.pi) > 3.2
        d = np.round((true + bend + self.noise * grains) / self.step) * self.step
        if self.filtered:
            d = smoothed(d, ~lost)
        z = fb / np.maximum(d, self.step)
        return np.where(lost | (z > 6.0) | (z < 0.3), 0.0, z)


Camera = Stereo | Matching | Flight


def shaded(disparity: Array) -> NDArray[np.bool_]:
    """Where the second imager, on the right, does not see: a nearer surface covers that column."""
    column = (np.arange(disparity.shape[1]) - disparity)[:, ::-1]
    return np.asarray(column > np.minimum.accumulate(column, axis=1) + 0.5)[:, ::-1]


def smoothed(d: Array, valid: NDArray[np.bool_], weight: float = 0.5, edge: float = 1.0) -> Array:
    """Recursive, forth and back along rows and then columns, twice; not across edges or holes."""
    out = d.copy()
    for _ in range(2):
        for flip in (False, True):
            image, ok = (out.T, valid.T) if flip else (out, valid)
            for order in (range(1, image.shape[1]), range(image.shape[1] - 2, -1, -1)):
                back = -1 if order.step > 0 else 1
                for i in order:
                    jump = np.abs(image[:, i] - image[:, i + back]) < edge
                    same = jump & ok[:, i] & ok[:, i + back]
                    mixed = (1 - weight) * image[:, i + back] + weight * image[:, i]
                    image[:, i] = np.where(same, mixed, image[:, i])
    return out


def taken(device: Camera, seen: Seen, rng: Rng) -> Array:
    """(h, w) depth [m] of a frame, 0 where there is none."""
    hits = Hits(seen.z, seen.part, seen.cosine, np.zeros((1, 1, 3)))
    return np.asarray(device.depth(hits, 0.0, rng))


def picture(colour: Array, exposure: float, rng: Rng) -> NDArray[np.uint8]:
    """(h, w, 3) as the colour camera gives it."""
    noisy = exposure * colour + 3.0 * rng.standard_normal(colour.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8)


STEREO = Pinhole(640, 480, 615.0, 319.5, 239.5)
HALF = Pinhole(424, 240, 310.0, 211.5, 119.5)  # a D435's smaller picture
CAMERAS: dict[str, Camera] = {
    "d415": Stereo(STEREO),
    "d415-filtered": Stereo(STEREO, filtered=True),
    "d435-small": Stereo(HALF, baseline=0.05, noise=0.06, shared=1.5),
    "kinect-v1": DEVICES["matching"],
    "kinect-v1-half": DEVICES["matching-half"],
    "azure-binned": DEVICES["flight"],
}
