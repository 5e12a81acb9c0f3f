"""Cyclic error (wiggling): the lamp is not modulated by a pure sine, and its harmonics bend the measured phase."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.geometry.camera import Principle
from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View

LINDNER = "Lindner and Kolb 2006, Kahlmann: from memory"


@dataclass(frozen=True)
class CyclicError(Effect):
    """A sum of sines of the range, one per harmonic; lists of equal length, a single number serves all harmonics."""

    name: ClassVar[str] = "cyclic_error"
    key: ClassVar[str] = "I1"
    formula: ClassVar[str] = (
        "range_measured = range + sum over the harmonics of amplitude sin(2 pi range / period + phase)"
    )
    variables: ClassVar[tuple[str, ...]] = ("range",)
    principles: ClassVar[tuple[Principle, ...]] = (Principle.TIME_OF_FLIGHT,)

    amplitude: Value = parameter(
        "m", (-0.1, 0.1), "height of the wave", f"{LINDNER}; 6 mm: Fankhauser 2015", typical=0.005, kind="list"
    )
    period: Value = parameter(
        "m",
        (0.02, 50),
        "range from one crest to the next: a fourth of c / 2f with four phase steps",
        f"{LINDNER}; 80 MHz and four steps where not given: guess",
        neutral=0.46875,
        kind="list",
        search=tuple(float(x) for x in np.geomspace(0.2, 4.0, 46)),
    )
    phase: Value = parameter("rad", (-20, 20), "of the wave at range 0", LINDNER, typical=0.5, kind="list")

    def bias(self, depth: Image, view: View) -> Image:
        r = depth * view.stretch
        total = np.zeros((), depth.dtype)
        for amplitude, period, phase in self._waves():
            if amplitude:
                total = total + amplitude * np.sin((2.0 * np.pi / period) * r + phase)
        return total / view.stretch

    def why_not_corrected(self) -> str:
        steepest = sum(abs(2.0 * np.pi * a / p) for a, p, _ in self._waves())
        return "" if steepest < 0.5 else "waves so short and high that a depth no longer tells where it comes from"

    def _waves(self) -> list[tuple[float, float, float]]:
        """Amplitude [m], period [m] and phase [rad] of each harmonic."""
        lists = np.broadcast_arrays(*(np.atleast_1d(p) for p in (self.amplitude, self.period, self.phase)))
        return [(float(a), float(p), float(f)) for a, p, f in zip(*lists, strict=True)]
