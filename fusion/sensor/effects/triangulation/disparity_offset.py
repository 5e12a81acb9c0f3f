"""Disparity offset: a turned projector or imager shifts every disparity alike, an error that grows with z^2."""

from dataclasses import dataclass
from typing import ClassVar

from fusion.geometry.camera import TRIANGULATING, Principle
from fusion.sensor.effect import Effect
from fusion.sensor.laws.disparity import depth_change
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class DisparityOffset(Effect):
    """d_measured = d + offset with d = fx b / z."""

    name: ClassVar[str] = "disparity_offset"
    key: ClassVar[str] = "G5"
    formula: ClassVar[str] = "d_measured = d + offset, d = fx b / z"
    variables: ClassVar[tuple[str, ...]] = ("depth",)
    principles: ClassVar[tuple[Principle, ...]] = TRIANGULATING

    # +-1.5 px keeps the slope of the bias below 0.5 up to 4.5 m for fx b = 43 px m
    offset: Value = parameter(
        "px", (-1.5, 1.5), "disparity measured too large", "triangulation: d = fx b / z; size: librealsense #13787"
    )

    def bias(self, depth: Image, view: View) -> Image:
        return depth_change(depth, self.offset, view)
