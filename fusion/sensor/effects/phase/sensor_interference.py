"""Sensor interference: another sensor of the same kind lights the scene at nearly the same frequency."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.geometry.camera import Principle
from fusion.sensor.effect import Effect
from fusion.sensor.laws.phasor import two_paths
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View

# shot noise of the other sensor's light, as much as that of the own light would make: 3 mm at 1000 count; guess
SHOT, IR_REFERENCE = 0.003, 1000.0


@dataclass(frozen=True)
class SensorInterference(Effect):
    """The other light, `fraction` of the own, turns against it at the beat: a slow wave of all depths, and shot noise.

    The other sensor stands beside this one, so that its light goes the same way and is in step at time 0.
    """

    name: ClassVar[str] = "sensor_interference"
    key: ClassVar[str] = "I13"
    formula: ClassVar[str] = (
        "range_measured = range + atan2(f sin D, 1 + f cos D) c / (4 pi f_m), D = 2 pi beat time; "
        "sigma_range = 3 mm sqrt(fraction 1000 / IR)"
    )
    variables: ClassVar[tuple[str, ...]] = ("time", "amplitude")
    per_frequency: ClassVar[bool] = True
    principles: ClassVar[tuple[Principle, ...]] = (Principle.TIME_OF_FLIGHT,)
    not_corrected: ClassVar[str] = "the other sensor's clock is not known"

    fraction: Value = parameter(
        "1", (0, 0.9), "the other sensor's light over the own one's", "sum of phasors; size: guess", typical=0.02
    )
    beat: Value = parameter(
        "Hz", (-1e6, 1e6), "difference of the two modulation frequencies", "sum of phasors; size: guess", neutral=0.1
    )

    def bias(self, depth: Image, view: View) -> Image:
        if not np.any(self.fraction):
            return np.zeros((), depth.dtype)
        return (self._both(view)[0] / view.stretch).astype(depth.dtype)

    def noise(self, depth: Image, view: View) -> Image:
        if not np.any(self.fraction):
            return np.zeros((), depth.dtype)
        falling = (depth * view.stretch) ** 2  # IR_REFERENCE / IR where no image tells it: 1 at 1 m
        if view.ir is not None:
            ir = np.asarray(view.ir, depth.dtype)
            falling = np.where(ir > 0, IR_REFERENCE / np.maximum(ir, 1.0), falling)
        return SHOT * np.sqrt(self.fraction * falling) / view.stretch

    def light(self, amplitude: Image, depth: Image, view: View) -> Image:
        return amplitude * np.asarray(self._both(view)[1], amplitude.dtype)

    def _both(self, view: View) -> tuple[Image, Image]:
        """Change of the range [m] and growth of the amplitude [1]."""
        # whole turns change nothing; the way of the same name is a share of the wavelength
        longer = view.wavelength * ((np.asarray(self.beat) * view.moment.time) % 1.0)
        return two_paths(1.0, np.asarray(self.fraction), longer, view)
