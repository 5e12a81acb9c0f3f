"""Depth quantisation: depths come in steps, of length or of disparity."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class DepthQuantization(Effect):
    """Rounding of d = fx b / z to multiples of step_px, then of z to multiples of step."""

    name: ClassVar[str] = "depth_quantization"
    key: ClassVar[str] = "N1"
    not_undone: ClassVar[str] = "rounding loses what it rounds off; it counts as noise of step / sqrt(12)"
    frozen: ClassVar[bool] = True

    step: Value = parameter(
        "m", (0, 0.1), "smallest difference of two depths", "sensor's number format", "length", typical=0.001
    )
    step_px: Value = parameter(
        "px",
        (0, 2),
        "smallest difference of two disparities",
        "1/8 px: github ankurhanda/simkinect",
        "disparity",
        typical=0.125,
    )

    def bias(self, depth: Image, view: View) -> Image:
        rounded = depth
        if np.any(self.step_px):
            fb = view.focal_baseline
            # a depth so large that its disparity rounds to 0 is held at one step
            rounded = fb / (np.maximum(np.round(fb / depth / self.step_px), 1) * self.step_px)
        if np.any(self.step):
            rounded = np.round(rounded / self.step) * self.step
        return rounded - depth

    def noise(self, depth: Image, view: View) -> Image:
        in_depth = self.step_px * depth**2 / view.focal_baseline
        return np.hypot(in_depth, self.step) / np.sqrt(12.0) + 0.0 * depth
