"""Multipath: light that comes by another surface joins the direct light, and the range comes out mostly too long."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.geometry.camera import Principle
from fusion.sensor.effect import Effect
from fusion.sensor.laws.phasor import two_paths
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class Multipath(Effect):
    """Two phasors: the direct light, and the sum of one bounce (`view.indirect`); nothing where that is not known."""

    name: ClassVar[str] = "multipath"
    key: ClassVar[str] = "I3"
    formula: ClassVar[str] = (
        "range_measured = range + atan2(q sin D, 1 + q cos D) c / (4 pi f), q = strength A2 / A1, D = 4 pi f path / c"
    )
    variables: ClassVar[tuple[str, ...]] = ("neighbours", "range", "reflectance")
    per_frequency: ClassVar[bool] = True
    principles: ClassVar[tuple[Principle, ...]] = (Principle.TIME_OF_FLIGHT,)
    not_corrected: ClassVar[str] = "one depth image does not hold the light of the other surfaces, seen or not"

    strength: Value = parameter(
        "1",
        (0, 10),
        "indirect light as a multiple of one bounce between diffuse surfaces",
        "two-path formula; Freedman 2014: from memory",
        typical=1.0,
    )

    def bias(self, depth: Image, view: View) -> Image:
        if view.indirect is None or not np.any(self.strength):
            return np.zeros((), depth.dtype)
        return self._both(depth, view)[0] / view.stretch

    def light(self, amplitude: Image, depth: Image, view: View) -> Image:
        if view.indirect is None or not np.any(self.strength):
            return amplitude
        return amplitude * self._both(depth, view)[1]

    def _both(self, depth: Image, view: View) -> tuple[Image, Image]:
        """Change of the range (h, w) [m] and growth of the amplitude (h, w) [1]."""
        assert view.indirect is not None
        ratio = np.nan_to_num(np.asarray(view.indirect.ratio * self.strength, depth.dtype))
        return two_paths(1.0, ratio, np.nan_to_num(np.asarray(view.indirect.path, depth.dtype)), view)
