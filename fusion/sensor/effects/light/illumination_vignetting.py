"""Illumination vignetting: the lamp is brightest on its axis, so that less light comes back from the image's border."""

from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np

from fusion.geometry.camera import Camera, Principle
from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View, stretch

IR_AT_1M = 1000.0  # [count] guess: a white frontal surface on the axis at 1 m, where the model does not say


@dataclass(frozen=True)
class IlluminationVignetting(Effect):
    """The amplitude falls with the ray's angle from the axis; depth follows only through what depends on light."""

    name: ClassVar[str] = "illumination_vignetting"
    key: ClassVar[str] = "I14"
    formula: ClassVar[str] = "IR = ir_at_1m reflectance cos(incidence) cos(psi)^exponent / range^2, psi from the axis"
    variables: ClassVar[tuple[str, ...]] = ("radius", "amplitude")
    principles: ClassVar[tuple[Principle, ...]] = (Principle.TIME_OF_FLIGHT,)

    exponent: Value = parameter(
        "1", (0, 10), "lamp profile cos^n of the angle from the axis", "cos^4 or a flood lens: from memory", typical=2.0
    )
    ir_at_1m: Value = parameter(
        "count",
        (0, 1e7),
        "amplitude of a white frontal surface on the axis at 1 m; 0 = not given",
        f"radiometry; {IR_AT_1M:g} count where not given: guess",
        "lamp",  # a file need not give it beside the exponent
        typical=2000.0,
    )

    def light(self, amplitude: Image, depth: Image, view: View) -> Image:
        if np.any(self.ir_at_1m):
            amplitude = amplitude * (self.ir_at_1m / IR_AT_1M)
        if np.ndim(self.exponent) == 0:
            return amplitude * _profile(view.camera, float(self.exponent))
        # the cosine of the ray's angle is 1 / stretch
        return amplitude * view.stretch ** -np.asarray(self.exponent, view.stretch.dtype)


@lru_cache(maxsize=8)
def _profile(camera: Camera, exponent: float) -> Image:
    """(h, w) what a lamp sends along each ray, 1 on the axis; read only."""
    share = stretch(camera) ** np.float32(-exponent)
    share.flags.writeable = False
    return share
