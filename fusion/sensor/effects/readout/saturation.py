"""Saturation: more light than a pixel can hold; its value is lost."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class Saturation(Effect):
    """No value where the amplitude reaches the threshold, at which it is also cut off."""

    name: ClassVar[str] = "saturation"
    key: ClassVar[str] = "N11"
    formula: ClassVar[str] = "missing where A >= ir_threshold; A_measured = min(A, ir_threshold)"
    variables: ClassVar[tuple[str, ...]] = ("amplitude",)

    ir_threshold: Value = parameter(
        "count",
        (0, 1e9),
        "largest amplitude; 0 for none",
        "libfreenect2: raw value 32767 means saturated",
        typical=1000.0,
    )

    def dropout(self, depth: Image, view: View) -> Image:
        if view.ir is None:
            return np.zeros((), depth.dtype)
        largest = np.asarray(self.ir_threshold, depth.dtype)
        # the amplitude that arrives here may have been cut off already, so reaching the threshold counts
        lost = (np.asarray(view.ir, depth.dtype) >= largest) & (largest > 0)
        return lost.astype(depth.dtype)

    def light(self, amplitude: Image, depth: Image, view: View) -> Image:
        largest = np.asarray(self.ir_threshold, amplitude.dtype)
        return np.where(largest > 0, np.minimum(amplitude, largest), amplitude) if np.any(largest) else amplitude
