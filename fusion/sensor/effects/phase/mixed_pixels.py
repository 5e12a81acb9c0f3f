"""Mixed pixels: a pixel that straddles a depth edge collects light of both sides, and shows neither of the ranges."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.laws.phasor import two_paths
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class MixedPixels(Effect):
    """S = (1 - a) S_own + a S_across, a the share of a square aperture of sqrt(fill) px that lies beyond the edge.

    The range falls between both sides, or outside of them when they differ by more than half a turn of the phase.
    A triangulating sensor matches the pattern of one side or the other and mixes nothing. Unchanged without edges.
    """

    name: ClassVar[str] = "mixed_pixels"
    key: ClassVar[str] = "I5"
    formula: ClassVar[str] = "S = (1 - a) S_own + a S_across, a = share of a square of area `fill` px beyond the edge"
    variables: ClassVar[tuple[str, ...]] = ("edge", "amplitude", "range")
    per_frequency: ClassVar[bool] = True
    not_corrected: ClassVar[str] = "one image does not tell how much of a pixel lies beyond an edge"

    fill: Value = parameter(
        "1",
        (0, 1),
        "share of the pixel area that collects light",
        "sum of phasors; 1 with a lens array: guess",
        typical=1.0,
    )

    def bias(self, depth: Image, view: View) -> Image:
        changed = np.zeros(depth.shape, depth.dtype)
        where = self._where(depth, view)
        if len(where):
            changed.flat[where] = self._both(where, depth, view)[0] / view.stretch.ravel()[where]
        return changed

    def light(self, amplitude: Image, depth: Image, view: View) -> Image:
        where = self._where(depth, view)
        if not len(where):
            return amplitude
        mixed = np.array(amplitude)
        mixed.flat[where] *= self._both(where, depth, view)[1]
        return mixed

    def _where(self, depth: Image, view: View) -> np.ndarray:
        """Flat indices of the pixels whose aperture an edge may cut: nearer than half its diagonal."""
        if view.edges is None or not view.time_of_flight or not np.any(self.fill):
            return np.zeros(0, np.intp)
        return np.flatnonzero(view.edges.distance < np.sqrt(0.5 * np.max(self.fill)))

    def _both(self, where: np.ndarray, depth: Image, view: View) -> tuple[Image, Image]:
        """Change of the range (n,) [m] and growth of the amplitude (n,) [1] of these pixels."""
        edges = view.edges
        assert edges is not None
        distance, direction, jump, ratio = (
            np.nan_to_num(np.asarray(image, depth.dtype).ravel()[where])
            for image in (edges.distance, edges.direction, edges.jump, edges.light)
        )
        width = np.sqrt(np.broadcast_to(np.asarray(self.fill, depth.dtype), depth.shape).ravel()[where])
        beyond = share_beyond(distance, direction, width)
        return two_paths(1.0 - beyond, beyond * ratio, jump * view.stretch.ravel()[where], view)


def share_beyond(distance: Image, direction: Image, width: Image) -> Image:
    """Share of a square of side `width` beyond a straight line that runs `distance` from its middle, in `direction`."""
    cos, sin = np.abs(np.cos(direction)), np.abs(np.sin(direction))
    long, short, half = np.maximum(cos, sin), np.minimum(cos, sin), np.maximum(width, 1e-6) / 2.0
    corner = np.maximum((long + short) * half - distance, 0.0)  # how deep the line cuts in from the farthest corner
    triangle = corner**2 / np.maximum(2.0 * long * short, 1e-9)
    trapezoid = 2.0 * half * (half - distance / long)
    return np.where(distance > (long - short) * half, triangle, trapezoid) / (2.0 * half) ** 2
