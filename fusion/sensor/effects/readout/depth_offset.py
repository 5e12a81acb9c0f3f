"""Depth offset: every depth too long by the same length."""

from dataclasses import dataclass
from typing import ClassVar

from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class DepthOffset(Effect):
    """z_measured = z + offset: the sensor's depth origin is not where the camera model puts it."""

    name: ClassVar[str] = "depth_offset"

    offset: Value = parameter(
        "m", (-0.5, 0.5), "depth measured at true depth 0", "Fankhauser 2015, section on depth distortion"
    )

    def bias(self, depth: Image, view: View) -> Image:
        return self.offset + 0.0 * depth
