"""Stray light: lens and housing spread some light over the image, so bright things pull dark ones to their range."""

from dataclasses import dataclass, replace
from typing import ClassVar

import cv2
import numpy as np

from fusion.geometry.camera import Principle
from fusion.sensor.effect import Effect
from fusion.sensor.laws.phasor import brightness, phasor, shift
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View

# the kernel is wide: pixels of a quarter of its width lose less than 1 % of its shape
SAMPLES_PER_WIDTH = 4.0
LEAST = 0.1  # of the IR image: a pixel with less light of its own is not corrected
WIDTH_OF_IMAGE = 1.0 / 3.0  # guess: what is called broad, where no width is given


@dataclass(frozen=True)
class StrayLight(Effect):
    """S' = S + fraction * (K conv S) of the light as a phasor, K a normal bell; changes nothing without an IR image.

    No light comes from outside the image, from missing pixels, or from surfaces that nobody sees.
    """

    name: ClassVar[str] = "stray_light"
    key: ClassVar[str] = "I4"
    formula: ClassVar[str] = "S' = S + fraction (K conv S), S = IR exp(4 pi i f range / c), K a bell of `width`"
    variables: ClassVar[tuple[str, ...]] = ("amplitude", "range", "neighbours")
    per_frequency: ClassVar[bool] = True
    principles: ClassVar[tuple[Principle, ...]] = (Principle.TIME_OF_FLIGHT,)
    not_corrected: ClassVar[str] = "it needs the light of the whole scene, also from outside the image"

    fraction: Value = parameter(
        "1", (0, 0.5), "share of the light received that is spread", "Schaefer et al. 2014, one scalar", typical=0.02
    )
    width: Value = parameter(
        "px",
        (0, 5000),
        "standard width of the spread; 0 = a third of the image width",
        "broad: Kavli et al., Schaefer et al. 2014; a third: guess",
        typical=60.0,
        search=(0.0, 8.0, 24.0, 64.0),
    )

    def bias(self, depth: Image, view: View) -> Image:
        if view.ir is None or not np.any(self.fraction):
            return np.zeros((), depth.dtype)
        light = phasor(self._own(view.ir, depth, view), depth, view)
        return shift(light, self._behind(phasor(view.ir, depth, view), light), view)

    def light(self, amplitude: Image, depth: Image, view: View) -> Image:
        if not np.any(self.fraction):
            return amplitude
        light = phasor(amplitude, depth, view)
        grown = brightness(self._behind(light, light))
        return np.where(np.isfinite(amplitude), grown, amplitude)

    def _own(self, amplitude: Image, depth: Image, view: View) -> Image:
        """The amplitude (h, w) without what has joined: to a dark pixel that is no small part of the IR image."""
        grown = np.zeros((), depth.dtype)
        each = [replace(view, modulation=f) for f in view.frequencies] or [view]
        for one in each:
            light = phasor(amplitude, depth, one)
            grown = grown + (brightness(self._behind(light, light)) - brightness(light)) / len(each)
        return np.maximum(amplitude - grown, LEAST * amplitude)

    def _behind(self, source: tuple[Image, Image], light: tuple[Image, Image]) -> tuple[Image, Image]:
        """The phasor (h, w), two parts, of light with what `source` spreads into every pixel."""
        spread = _spread(np.dstack(source), float(np.mean(self.width)))
        return light[0] + self.fraction * spread[..., 0], light[1] + self.fraction * spread[..., 1]


def _spread(image: Image, width: float) -> Image:
    """(h, w, 2) smoothed by a bell of standard width [px], 0 outside; computed on a smaller image."""
    height, columns = image.shape[:2]
    width = width or columns * WIDTH_OF_IMAGE
    factor = max(width / SAMPLES_PER_WIDTH, 1.0)
    size = max(round(columns / factor), 1), max(round(height / factor), 1)
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    sigmas = width * size[0] / columns, width * size[1] / height
    # a kernel of 3 widths holds 99.7 % of the bell; OpenCV's own choice for floating point is 4
    small = cv2.GaussianBlur(small, (0, 0), sigmas[0], sigmaY=sigmas[1], borderType=cv2.BORDER_CONSTANT)
    return np.asarray(cv2.resize(small, (columns, height), interpolation=cv2.INTER_LINEAR), image.dtype)
