"""Speckle noise: the laser's grain moves every dot a little, the same way for as long as nothing moves."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.geometry.camera import TRIANGULATING, Principle
from fusion.sensor.effect import Effect
from fusion.sensor.laws.disparity import depth_change
from fusion.sensor.laws.fields import frozen_field
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class SpeckleNoise(Effect):
    """d_measured = d + sigma_px times a normal field, which only a new placement of the scene draws anew."""

    name: ClassVar[str] = "speckle_noise"
    key: ClassVar[str] = "N5"
    formula: ClassVar[str] = "d_measured = d + sigma_px n(u, v), n frozen while the scene stands still"
    variables: ClassVar[tuple[str, ...]] = ("depth",)
    principles: ClassVar[tuple[Principle, ...]] = TRIANGULATING
    not_corrected: ClassVar[str] = "each placement of the scene has another grain, which one image does not tell"
    frozen: ClassVar[str] = "scene"
    grain: ClassVar[tuple[str, ...]] = ("sigma_px", "correlation_px")

    sigma_px: Value = parameter("px", (0, 1), "spread of the disparity", "0.05 to 0.15 px, from memory", typical=0.05)
    correlation_px: Value = parameter(
        "px",
        (0, 50),
        "side of the window over which neighbours share their error",
        "matching window: 9 x 9 px in github ankurhanda/simkinect",
        neutral=5.0,
    )

    def bias(self, depth: Image, view: View) -> Image:
        if view.moment.placement is None or not np.any(self.sigma_px):
            return np.zeros((), depth.dtype)
        width = float(np.mean(self.correlation_px))
        grain = frozen_field(depth.shape, width, self.name, view.moment.placement, window=True)
        return depth_change(depth, np.asarray(self.sigma_px, depth.dtype) * grain, view)

    def window(self, view: View) -> float:
        return max(1.0, float(np.mean(self.correlation_px)))

    def noise(self, depth: Image, view: View) -> Image:
        spread = np.asarray(self.sigma_px, depth.dtype) / depth.dtype.type(view.focal_baseline)
        return spread * depth**2
