"""Column delay: the modulation reaches each column and row of the chip a little later than the one before."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.geometry.camera import Principle
from fusion.sensor.effect import Effect
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class ColumnDelay(Effect):
    """A range error that is linear in the image, 0 at the principal point."""

    name: ClassVar[str] = "column_delay"
    key: ClassVar[str] = "N8"
    formula: ClassVar[str] = "range_measured = range + slope (u - cx) + slope_v (v - cy)"
    variables: ClassVar[tuple[str, ...]] = ("u", "v")
    principles: ClassVar[tuple[Principle, ...]] = (Principle.TIME_OF_FLIGHT,)

    slope: Value = parameter(
        "m/px", (-1e-3, 1e-3), "error from column to column", "mm to cm over an image: from memory", typical=3e-5
    )
    slope_v: Value = parameter(
        "m/px", (-1e-3, 1e-3), "error from row to row", "mm to cm over an image: from memory", typical=-2e-5
    )

    def bias(self, depth: Image, view: View) -> Image:
        along_u = self.slope * (view.u - np.float32(view.camera.cx))
        along_v = self.slope_v * (view.v - np.float32(view.camera.cy))
        return ((along_u + along_v) / view.stretch).astype(depth.dtype)

    def other_zero(self, view: View) -> Effect | None:
        """Signals are in time where they come in, at any column or row of the chip or beside it."""
        camera = view.camera
        return DepthOffset(abs(float(self.slope)) * camera.width + abs(float(self.slope_v)) * camera.height)
