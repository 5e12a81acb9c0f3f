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
    """The range grows by the path inside the material, where the mesh says that it is translucent, and not where it
    says that it is not (`scalar_translucent` 1 and 0 of its vertices); where it says nothing, everywhere.
    """

    name: ClassVar[str] = "subsurface_scattering"
    key: ClassVar[str] = "I11"
    formula: ClassVar[str] = "range_measured = range + path; triangulation: z_measured = z + 0.1 path"
    variables: ClassVar[tuple[str, ...]] = ("range", "material")

    path: Value = parameter(
        "m",
        (0, 0.2),
        "lengthening of the range by the way inside the material, there and back over two",
        "mm to cm in wax, skin, soap, foam: from memory",
        typical=0.005,
    )

    def bias(self, depth: Image, view: View) -> Image:
        seen = view.along_ray if view.time_of_flight else SEEN_BY_TRIANGULATION
        inside = 1.0 if view.translucent is None else np.nan_to_num(view.translucent, nan=1.0)
        return np.asarray(self.path * seen * inside, depth.dtype)
