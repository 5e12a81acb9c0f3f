"""Ambient flicker: lamps pulse at twice the mains frequency, and with them the noise that their light makes."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.effects.light.ambient_light import added_noise
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View

ROOM_LUX = 500.0  # a lit office, where the moment does not state its light: EN 12464-1


@dataclass(frozen=True)
class AmbientFlicker(Effect):
    """Noise of a pulsing share of the light, 0 when the lamps are dark; frames see the pulse at a lower, aliased pace.

    Exposures are taken as short against the pulse.
    """

    name: ClassVar[str] = "ambient_flicker"
    key: ClassVar[str] = "T2"
    formula: ClassVar[str] = "light = ambient (1 + amplitude (1 + sin(2 pi frequency time))), noise as in ambient_light"
    variables: ClassVar[tuple[str, ...]] = ("time", "ambient", "range")

    amplitude: Value = parameter(
        "1", (0, 1), "swing of the light over its smallest value, half from dark to bright", "guess", typical=1.0
    )
    frequency: Value = parameter(
        "Hz", (0, 1000), "of the light: twice that of the mains", "100 or 120 Hz", neutral=100.0
    )

    def noise(self, depth: Image, view: View) -> Image:
        if not np.any(self.amplitude):
            return np.zeros((), depth.dtype)
        least = view.moment.ambient or ROOM_LUX
        pulse = np.sin(2.0 * np.pi * self.frequency * view.moment.time)
        more = np.maximum(self.amplitude * (1.0 + pulse), 0.0) * least
        return added_noise(least, np.asarray(more, depth.dtype), depth, view)
