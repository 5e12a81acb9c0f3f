"""Phase wrapping: a phase tells a range only up to whole turns, so what is far appears near."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.geometry.camera import Principle
from fusion.sensor.effect import Effect
from fusion.sensor.forms import Form
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class PhaseWrapping(Effect):
    """The measured range is what is left of it after whole multiples of `range`."""

    name: ClassVar[str] = "phase_wrapping"
    key: ClassVar[str] = "I8"
    formula: ClassVar[str] = "range_measured = range_true modulo range"
    variables: ClassVar[tuple[str, ...]] = ("range",)
    principles: ClassVar[tuple[Principle, ...]] = (Principle.TIME_OF_FLIGHT,)
    not_corrected: ClassVar[str] = "a wrapped range looks like any other"

    range: Value = parameter(
        "m", (0, 100), "longest range that is told apart, c / 2f of one frequency; 0 = all", "derived", typical=1.874
    )

    def bias(self, depth: Image, view: View) -> Image:
        if not np.any(self.range):
            return np.zeros((), depth.dtype)
        longest = np.asarray(self.range, depth.dtype)
        turns = np.floor(depth * view.stretch / np.where(longest > 0, longest, np.inf))
        return -turns * longest / view.stretch

    @classmethod
    def own_forms(cls, shape: tuple[int, int]) -> list[Form]:
        """None: what wraps does so by whole ranges, and no share of one is a law."""
        return []
