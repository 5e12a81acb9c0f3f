"""Mixed pixels: a pixel that straddles a depth edge collects light of both sides, and shows neither of the ranges."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect, over_modulations
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
        return self._changed(depth, view, lambda law: law(view))

    def light(self, amplitude: Image, depth: Image, view: View) -> Image:
        where = self._where(depth, view)
        if not len(where):
            return amplitude
        mixed = np.array(amplitude)
        mixed.flat[where] *= two_paths(*self._paths(where, depth, view), view)[1]
        return mixed

    def _everywhere(self, depth: Image, view: View) -> Image:
        return self._changed(depth, view, lambda law: over_modulations(law, view))

    def _changed(self, depth: Image, view: View, mean: Callable[[Callable[[View], Image]], Image]) -> Image:
        """Pixels beside edges are few: the mean over modulations is theirs alone."""
        where = self._where(depth, view)
        if not len(where):
            return np.zeros((), depth.dtype)
        paths = self._paths(where, depth, view)
        changed = np.zeros(depth.shape, depth.dtype)
        changed.flat[where] = mean(lambda one: two_paths(*paths, one)[0]) / view.stretch.ravel()[where]
        return changed

    def _where(self, depth: Image, view: View) -> np.ndarray:
        """Flat indices of the pixels whose aperture an edge may cut: nearer than half its diagonal."""
        if view.edges is None or not view.time_of_flight or not np.any(self.fill):
            return np.zeros(0, np.intp)
        return np.flatnonzero(view.edges.distance < np.sqrt(0.5 * np.max(self.fill)))

    def _paths(self, where: np.ndarray, depth: Image, view: View) -> tuple[Image, Image, Image]:
        """Of these pixels: share of the own light, of that across the edge (n,) [1], and how much farther it is [m]."""
        edges = view.edges
        assert edges is not None
        distance, direction, jump, ratio = (
            np.nan_to_num(np.asarray(image, depth.dtype).ravel()[where])
            for image in (edges.distance, edges.direction, edges.jump, edges.light)
        )
        width = np.sqrt(np.broadcast_to(np.asarray(self.fill, depth.dtype), depth.shape).ravel()[where])
        beyond = share_beyond(distance, direction, width)
        return 1.0 - beyond, beyond * ratio, jump * view.stretch.ravel()[where]


def share_beyond(distance: Image, direction: Image, width: Image) -> Image:
    """Share of a square of side `width` beyond a straight line that runs `distance` from its middle, in `direction`."""
    cos, sin = np.abs(np.cos(direction)), np.abs(np.sin(direction))
    long, short, half = np.maximum(cos, sin), np.minimum(cos, sin), np.maximum(width, 1e-6) / 2.0
    corner = np.maximum((long + short) * half - distance, 0.0)  # how deep the line cuts in from the farthest corner
    triangle = corner**2 / np.maximum(2.0 * long * short, 1e-9)
    trapezoid = 2.0 * half * (half - distance / long)
    return np.where(distance > (long - short) * half, triangle, trapezoid) / (2.0 * half) ** 2
