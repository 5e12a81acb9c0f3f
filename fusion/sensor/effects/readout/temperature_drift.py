"""Temperature drift: warming stretches housing, lens and delays; lengths or disparities follow the temperature."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.effects.triangulation.disparity_offset import DisparityOffset
from fusion.sensor.laws.disparity import depth_change
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View

KELVIN = "mm per K: Fiedler and Mueller 2012 (from memory); RealSense follows its temperature: librealsense #13787"
WARM_UP = "Toelgyessy 2021: an Azure Kinect warms up for 40 to 50 minutes; Pagliari 2014"


@dataclass(frozen=True)
class TemperatureDrift(Effect):
    """A change that is proportional to the temperature, or that grows with the time since switching on, or both.

    In metres (along the ray for time of flight) or in pixels of disparity. In files both units stand under one name.
    """

    name: ClassVar[str] = "temperature_drift"
    key: ClassVar[str] = "T1"
    formula: ClassVar[str] = (
        "length or disparity + coefficient (T - reference_temperature) + amplitude (1 - exp(-t / time_constant))"
    )
    variables: ClassVar[tuple[str, ...]] = ("temperature", "time", "depth")

    coefficient: Value = parameter("m/K", (-0.02, 0.02), "change of the length per K", KELVIN, "kelvin", typical=0.001)
    coefficient_px: Value = parameter(
        "px/K",
        (-0.05, 0.05),
        "change of the disparity per K",
        KELVIN,
        "kelvin",
        typical=0.005,
        label="coefficient",
    )
    reference_temperature: Value = parameter(
        "degC", (0, 50), "where there is no error", "usual room", "kelvin", neutral=25.0, release=(15.0, 35.0)
    )
    amplitude: Value = parameter(
        "m", (-0.2, 0.2), "change of the length from cold to warm", WARM_UP, "warm-up", typical=0.005
    )
    amplitude_px: Value = parameter(
        "px",
        (-0.5, 0.5),
        "change of the disparity from cold to warm",
        WARM_UP,
        "warm-up",
        typical=0.05,
        label="amplitude",
    )
    time_constant: Value = parameter(
        "s",
        (1, 1e5),
        "time in which 63 % of the change happen",
        WARM_UP,
        "warm-up",
        neutral=900.0,
        search=(150.0, 400.0, 1000.0, 2500.0),
    )

    def bias(self, depth: Image, view: View) -> Image:
        moment = view.moment
        # an unknown temperature is taken to be the reference
        warmer = (moment.temperature - np.asarray(self.reference_temperature)) * np.isfinite(moment.temperature)
        warmer = np.nan_to_num(warmer)
        grown = -np.expm1(-moment.time / np.asarray(self.time_constant))
        length = np.asarray(self.coefficient * warmer + self.amplitude * grown, depth.dtype) * view.along_ray
        shift = self.coefficient_px * warmer + self.amplitude_px * grown
        return length + depth_change(depth, shift, view) if np.any(shift) else length

    def other_zero(self, view: View) -> Effect | None:
        """Without a thermometer nobody knows how warm the camera was when its clock began."""
        if np.isfinite(view.moment.temperature):
            return None
        if np.any(self.amplitude_px):
            return DisparityOffset(self.amplitude_px)
        return DepthOffset(self.amplitude) if np.any(self.amplitude) else None
