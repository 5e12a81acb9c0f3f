"""Depth scale: every depth is too long (below 0 too short) by the same share, as from a wrong baseline or clock."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class DepthScale(Effect):
    """z_measured = (1 + scale) z, which is the same as (1 + scale) times the distance along the ray."""

    name: ClassVar[str] = "depth_scale"
    key: ClassVar[str] = "G4"
    formula: ClassVar[str] = "z_measured = (1 + scale) z"
    variables: ClassVar[tuple[str, ...]] = ("depth",)

    scale: Value = parameter(
        "1", (-0.3, 0.3), "relative error of the depth", "first principles; typical 0.001-0.01 is a guess"
    )

    def bias(self, depth: Image, view: View) -> Image:
        return np.asarray(self.scale, depth.dtype) * depth
