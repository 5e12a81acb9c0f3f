"""Emitter parallax: the lamp of a time-of-flight sensor stands beside the lens, so light goes and comes two ways."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.geometry.camera import Principle
from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class EmitterParallax(Effect):
    """The sensor takes half of the whole way, (r_tx + r) / 2, for the range r from the lens.

    About -(b/2) sin psi + b^2 cos^2 psi / (4 r), psi the ray's angle in the plane of lamp and axis.
    """

    name: ClassVar[str] = "emitter_parallax"
    key: ClassVar[str] = "G8"
    formula: ClassVar[str] = "range_measured = (r_tx + r) / 2, r_tx^2 = r^2 - 2 r baseline sin(psi) + baseline^2"
    variables: ClassVar[tuple[str, ...]] = ("u", "v", "range")
    principles: ClassVar[tuple[Principle, ...]] = (Principle.TIME_OF_FLIGHT,)

    # a lamp 0.3 m away keeps the slope of the bias below 0.5 wherever a ray leaves within 60 deg of the axis
    baseline: Value = parameter("m", (-0.3, 0.3), "from the lens to the lamp", "geometry, derived", typical=0.05)
    direction: Value = parameter(
        "rad", (-6.3, 6.3), "where the lamp is: 0 to the right (+u), pi/2 below (+v)", "geometry, derived"
    )

    def bias(self, depth: Image, view: View) -> Image:
        if not np.any(self.baseline):
            return np.zeros((), depth.dtype)
        b, r = np.asarray(self.baseline, depth.dtype), depth * view.stretch
        x, y = np.moveaxis(view.camera.rays(), -1, 0)
        # 2 r b sin(psi), as the ray is (x, y, 1) / stretch; b^2 - this is r_tx^2 - r^2
        longer = b * b - 2.0 * depth * (b * np.cos(self.direction) * x + b * np.sin(self.direction) * y)
        # (r_tx - r) / 2 without the difference of nearly equal numbers
        return (0.5 * longer / ((np.sqrt(r * r + longer) + r) * view.stretch)).astype(depth.dtype)
