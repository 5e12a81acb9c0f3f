"""Projector thermal drift: warming shifts the laser's wavelength, so the grating throws the whole pattern wider."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.geometry.camera import TRIANGULATING, Principle
from fusion.sensor.effect import Effect
from fusion.sensor.laws.disparity import depth_change
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class ProjectorThermalDrift(Effect):
    """The grating scales the sine of each dot's angle, so dots move outwards and seem to belong to other depths.

    With p the projector's place on the x axis, a dot leaves it at the slope x_p = x - p / z, which grows by
    dx = coefficient (T - T_ref) x_p (1 + x_p^2 + y^2); the disparity fx |p| / z changes by sign(p) fx dx. Of a stereo
    camera it stands for its other imager, whose scale follows the temperature.
    """

    name: ClassVar[str] = "projector_thermal_drift"
    key: ClassVar[str] = "S4"
    formula: ClassVar[str] = (
        "d_measured = d + sign(baseline) fx coefficient (T - reference_temperature) x_p (1 + x_p^2 + y^2), "
        "x_p = x - baseline / z"
    )
    variables: ClassVar[tuple[str, ...]] = ("u", "temperature", "depth")
    principles: ClassVar[tuple[Principle, ...]] = TRIANGULATING

    coefficient: Value = parameter(
        "1/K",
        (-0.001, 0.001),
        "relative change of the angle between a dot and the projector's axis",
        "0.3 nm/K of 830 nm: 3.6e-4 where nothing is done against it; from memory",
        typical=2e-4,
    )
    reference_temperature: Value = parameter(
        "degC", (0, 50), "at which the pattern was stored", "usual room", neutral=25.0, release=(15.0, 35.0)
    )

    def bias(self, depth: Image, view: View) -> Image:
        warmer = view.moment.temperature - float(self.reference_temperature)
        if not np.isfinite(warmer) or not np.any(self.coefficient):
            return np.zeros((), depth.dtype)
        rays = view.camera.rays().astype(depth.dtype, copy=False)
        x = rays[..., 0] - depth.dtype.type(view.baseline) / depth
        wider = np.asarray(self.coefficient * (warmer * view.camera.fx * np.sign(view.baseline)), depth.dtype)
        return depth_change(depth, wider * x * (1 + x**2 + rays[..., 1] ** 2), view)
