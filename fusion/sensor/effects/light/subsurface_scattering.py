"""Subsurface scattering: light enters wax, skin or soap and comes back from below the surface."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View

# a dot of structured light spreads around where it entered, and its middle sinks only a little: guess
SEEN_BY_TRIANGULATION = 0.1


@dataclass(frozen=True)
class SubsurfaceScattering(Effect):
    """The range grows by the path inside the material, the same in all pixels, as materials are not told apart."""

    name: ClassVar[str] = "subsurface_scattering"
    key: ClassVar[str] = "I11"
    formula: ClassVar[str] = "range_measured = range + path; triangulation: z_measured = z + 0.1 path"
    variables: ClassVar[tuple[str, ...]] = ("range",)

    path: Value = parameter(
        "m",
        (0, 0.2),
        "lengthening of the range by the way inside the material, there and back over two",
        "mm to cm in wax, skin, soap, foam: from memory",
        typical=0.005,
    )

    def bias(self, depth: Image, view: View) -> Image:
        seen = view.along_ray if view.time_of_flight else SEEN_BY_TRIANGULATION
        return np.asarray(self.path * seen, depth.dtype)
