"""Depth offset: every distance is too long (below 0 too short) by the same length."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class DepthOffset(Effect):
    """The origin of the distances is not where the camera model puts it; along the ray for time of flight."""

    name: ClassVar[str] = "depth_offset"
    formula: ClassVar[str] = "z_measured = z + offset; itof: r_measured = r + offset"
    variables: ClassVar[tuple[str, ...]] = ()

    offset: Value = parameter(
        "m",
        (-0.5, 0.5),
        "depth measured at true depth 0",
        "below 11 mm: Microsoft, Azure Kinect DK hardware specification; Tolgyessy 2021",
        typical=0.01,
    )

    def bias(self, depth: Image, view: View) -> Image:
        return np.asarray(self.offset, depth.dtype) * view.along_ray
