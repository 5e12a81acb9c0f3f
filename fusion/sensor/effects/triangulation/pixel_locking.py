"""Pixel locking: interpolation between whole pixels pulls every disparity towards, or away from, whole numbers."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.geometry.camera import TRIANGULATING, Principle
from fusion.sensor.effect import Effect
from fusion.sensor.laws.disparity import depth_change, disparity
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View

# share by which the slope of d_measured over d may differ from 1; beyond, the inverse gets rough, at 1 it is lost
STEEPEST = 0.4


@dataclass(frozen=True)
class PixelLocking(Effect):
    """d_measured = d + amplitude sin(2 pi d / period): fringes on tilted walls, at equal steps of disparity."""

    name: ClassVar[str] = "pixel_locking"
    key: ClassVar[str] = "N9"
    formula: ClassVar[str] = "d_measured = d + amplitude sin(2 pi d / period), d = fx b / z"
    variables: ClassVar[tuple[str, ...]] = ("disparity",)
    principles: ClassVar[tuple[Principle, ...]] = TRIANGULATING

    amplitude: Value = parameter(
        "px",
        (-0.5, 0.5),
        "largest error of the disparity; negative pulls to whole periods",
        "0.02 to 0.1 px: Shimizu and Okutomi 2001 (from memory); waves on a wall: librealsense #2723",
        typical=0.05,
    )
    period: Value = parameter(
        "px",
        (0.05, 20),
        "of disparity",
        "the pixel in which the sensor matches",
        neutral=1.0,
        typical=1.0,
        search=(0.25, 0.5, 1.0, 2.0),
    )

    def bias(self, depth: Image, view: View) -> Image:
        phase = disparity(depth, view) * np.asarray(2 * np.pi / self.period, depth.dtype)
        return depth_change(depth, np.asarray(self.amplitude, depth.dtype) * np.sin(phase), view)

    def why_not_corrected(self) -> str:
        steep = 2 * np.pi * np.max(np.abs(self.amplitude / np.asarray(self.period))) > STEEPEST
        return "its fringes are so steep that depths cannot be told apart" if steep else ""
