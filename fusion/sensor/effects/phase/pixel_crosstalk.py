"""Pixel crosstalk: a share of a pixel's light or charge is counted by its four neighbours."""

from dataclasses import dataclass
from typing import ClassVar

import cv2
import numpy as np

from fusion.geometry.camera import Principle
from fusion.sensor.effect import Effect
from fusion.sensor.laws.phasor import brightness, phasor, shift
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View

NEIGHBOURS = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 0.0]])


@dataclass(frozen=True)
class PixelCrosstalk(Effect):
    """S' = (1 - fraction) S + fraction * mean of the four neighbours, as phasors; nothing without an IR image.

    It turns a step of amplitude into an error of depth, also on a plane that is seen at an angle.
    """

    name: ClassVar[str] = "pixel_crosstalk"
    key: ClassVar[str] = "I6"
    formula: ClassVar[str] = "S' = (1 - fraction) S + fraction / 4 sum of S of the four neighbours, S = IR exp(i phase)"
    variables: ClassVar[tuple[str, ...]] = ("edge", "amplitude", "range")
    per_frequency: ClassVar[bool] = True
    principles: ClassVar[tuple[Principle, ...]] = (Principle.TIME_OF_FLIGHT,)
    not_corrected: ClassVar[str] = "what a missing neighbour counted is not known, and next to it all is noise"

    fraction: Value = parameter(
        "1", (0, 0.5), "share of the light that the four neighbours count", "1 to 5 %: from memory", typical=0.03
    )

    def bias(self, depth: Image, view: View) -> Image:
        if view.ir is None or not np.any(self.fraction):
            return np.zeros((), depth.dtype)
        light = phasor(view.ir, depth, view)
        return shift(light, self._behind(light), view)

    def light(self, amplitude: Image, depth: Image, view: View) -> Image:
        if not np.any(self.fraction):
            return amplitude
        crossed = brightness(self._behind(phasor(amplitude, depth, view)))
        return np.where(np.isfinite(amplitude), crossed, amplitude)

    def _behind(self, light: tuple[Image, Image]) -> tuple[Image, Image]:
        """The phasor (h, w), two parts, behind the crosstalk."""
        kept, given = 1.0 - self.fraction, self.fraction / 4.0
        return kept * light[0] + given * _four(light[0]), kept * light[1] + given * _four(light[1])


def _four(image: Image) -> Image:
    """(h, w) sum of the four neighbours; nothing comes from outside the image."""
    return np.asarray(cv2.filter2D(image, -1, NEIGHBOURS, borderType=cv2.BORDER_CONSTANT))
