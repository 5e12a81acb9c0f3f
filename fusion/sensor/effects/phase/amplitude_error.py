"""Amplitude error: the range depends on how much light came back, so dark patches stand off from bright ones."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.geometry.camera import Principle
from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View

MOST = 1e4  # ir_reference / IR is held here: less than this is no light


@dataclass(frozen=True)
class AmplitudeError(Effect):
    """A power of the amplitude; nothing changes where the amplitude is not known or 0."""

    name: ClassVar[str] = "amplitude_error"
    key: ClassVar[str] = "I2"
    formula: ClassVar[str] = "range_measured = range + coefficient (ir_reference / IR)^exponent"
    variables: ClassVar[tuple[str, ...]] = ("amplitude",)
    principles: ClassVar[tuple[Principle, ...]] = (Principle.TIME_OF_FLIGHT,)

    coefficient: Value = parameter(
        "m", (-0.1, 0.1), "error at the reference amplitude", "mm to cm: from memory", typical=0.002
    )
    exponent: Value = parameter(
        "1",
        (0, 3),
        "power of the darkness",
        "1 is exact for a constant stray phasor, derived",
        neutral=1.0,
        search=(0.5, 1.0, 2.0),
    )
    ir_reference: Value = parameter(
        "count", (1e-3, 1e7), "amplitude at which the coefficient is given", "definition", neutral=1000.0
    )

    def bias(self, depth: Image, view: View) -> Image:
        if view.ir is None or not np.any(self.coefficient):
            return np.zeros((), depth.dtype)
        ir = np.asarray(view.ir, depth.dtype)
        known = ir > 0
        reference = np.asarray(self.ir_reference, depth.dtype)
        dark = np.minimum(reference / np.where(known, ir, reference), MOST)
        power = dark if np.all(self.exponent == 1) else dark ** np.asarray(self.exponent, depth.dtype)
        change = self.coefficient * power / view.stretch
        return np.where(known, change, 0.0).astype(depth.dtype)

    def corrected(self, measured: Image, view: View) -> Image | None:
        """By the amplitude alone, whatever the depth; one that holds in a region asks where the true depth lies."""
        return None if self.where else (measured - self.change(measured, view)).astype(measured.dtype)
