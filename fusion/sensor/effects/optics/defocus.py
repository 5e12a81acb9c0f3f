"""Defocus: a blurred lens lets a pixel see its surroundings, and beside a depth edge the other side of it."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.edges.mixing import mixed
from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class Defocus(Effect):
    """A Gaussian blur of standard deviation `width`: at a distance d from a straight edge, Phi(-d / width) of what a
    pixel sees lies across it. Unchanged where the edges are not known.
    """

    name: ClassVar[str] = "defocus"
    key: ClassVar[str] = "I7"
    formula: ClassVar[str] = "share across the edge = Phi(-edge distance / width); itof adds phasors, others the mean"
    variables: ClassVar[tuple[str, ...]] = ("edge", "amplitude", "depth")
    per_frequency: ClassVar[bool] = True
    not_corrected: ClassVar[str] = "one image does not tell what a blurred edge pixel saw on each side"

    width: Value = parameter(
        "px", (0, 20), "standard deviation of the blur", "first principles; size: guess", typical=0.7
    )

    def bias(self, depth: Image, view: View) -> Image:
        return mixed(self._share(depth, view), depth, view)[0]

    def light(self, amplitude: Image, depth: Image, view: View) -> Image:
        return amplitude * mixed(self._share(depth, view), depth, view)[1]

    def _share(self, depth: Image, view: View) -> Image:
        """Share (h, w) of what a pixel sees that lies across its nearest edge."""
        share = np.zeros_like(depth)
        if view.edges is not None and np.any(self.width):
            width = np.broadcast_to(np.asarray(self.width, depth.dtype), depth.shape)
            # four standard deviations away 3e-5 of the light is left; beyond it the edge counts as out of sight
            where = np.nonzero(view.edges.distance < 4 * width)
            from scipy.special import ndtr

            share[where] = ndtr(-view.edges.distance[where] / width[where])
        return share
