"""Fixed pattern: every pixel has its own constant error of length, from its own electronics."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.laws.fields import frozen_map
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class FixedPattern(Effect):
    """F(u, v) is added to the length, along the ray for time of flight: a map, or a frozen draw of given size."""

    name: ClassVar[str] = "fixed_pattern"
    key: ClassVar[str] = "N6"
    formula: ClassVar[str] = "z_measured = z + F(u, v); itof: r_measured = r + F(u, v)"
    variables: ClassVar[tuple[str, ...]] = ("u", "v")
    frozen: ClassVar[str] = "unit"
    grain: ClassVar[tuple[str, ...]] = ("rms",)

    rms: Value = parameter(
        "m",
        (0, 0.05),
        "size of an error that differs from pixel to pixel and that this unit keeps, over the image",
        "1 to 10 mm, from memory; image-sensors-world 2019/11",
        "rms",
        typical=0.003,
    )
    map: Value = parameter("m", (-0.2, 0.2), "error of each pixel", "measured", "map", typical=0.003, kind="map")

    def bias(self, depth: Image, view: View) -> Image:
        error = np.asarray(self.map, depth.dtype)
        if np.any(self.rms) and view.moment.unit is not None:
            error = error + np.asarray(self.rms, depth.dtype) * frozen_map(depth.shape, 0, self.name, view.moment.unit)
        return error * view.along_ray

    def noise(self, depth: Image, view: View) -> Image:
        return np.asarray(self.rms, depth.dtype) * view.along_ray
