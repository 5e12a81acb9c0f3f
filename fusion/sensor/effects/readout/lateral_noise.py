"""Lateral noise: the edge of a thing jitters sideways, so edge pixels jump between the surfaces on both sides."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import ndtr

from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View

# a neighbour this much (share of the depth) nearer or farther is another surface; 85 deg of tilt at fx = 585 px
JUMP = 0.02


@dataclass(frozen=True)
class LateralNoise(Effect):
    """A pixel beside a depth edge shows its neighbour when a normal jitter exceeds half a pixel."""

    name: ClassVar[str] = "lateral_noise"
    key: ClassVar[str] = "N4"
    not_undone: ClassVar[str] = "one image does not tell on which side of an edge a jittering pixel belongs"

    sigma_px: Value = parameter(
        "px", (0, 10), "jitter of an edge", "Nguyen, Izadi, Lovell 2012: 0.8 px", "pixels", typical=0.6
    )
    sigma: Value = parameter(
        "m", (0, 0.1), "jitter of an edge", "Fankhauser 2015, equations 2, 3 and 5", "length", typical=0.0005
    )

    def bias(self, depth: Image, view: View) -> Image:
        return self._probability(depth, view) * jump(depth)

    def noise(self, depth: Image, view: View) -> Image:
        p = self._probability(depth, view)
        return np.abs(jump(depth)) * np.sqrt(p * (1.0 - p))

    def draw(self, depth: Image, view: View, rng: np.random.Generator) -> Image:
        p = self._probability(depth, view)
        return ((rng.random(depth.shape) < p) - p) * jump(depth)

    def _probability(self, depth: Image, view: View) -> Image:
        """Share (h, w) of frames in which an edge half a pixel away passes the pixel's centre."""
        spread = np.hypot(self.sigma_px, self.sigma * view.camera.fx / depth)
        return ndtr(-0.5 / np.maximum(spread, 1e-9))


def jump(depth: Image) -> Image:
    """Depth (h, w) [m] of the four neighbours' most different one minus the pixel's own; 0 away from edges."""
    best = np.zeros_like(depth)
    for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
        other = np.roll(depth, step, axis)
        border = (0 if step == 1 else -1,)
        other[border if axis == 0 else (slice(None), *border)] = np.nan
        difference = other - depth
        take = (np.abs(difference) > np.abs(best)) & (np.abs(difference) > JUMP * depth)
        best = np.where(take, difference, best)
    return np.where(np.isfinite(depth), best, np.nan).astype(depth.dtype)
