"""Amplitude dropout: with too little light the sensor does not trust its own value and gives none."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View

DIM = 0.01  # share of the light of a white surface that faces the lamp: less is as good as none
HARD = 0.02  # width of a threshold without a width, as its share: guess, the light's own noise


@dataclass(frozen=True)
class AmplitudeDropout(Effect):
    """The chance of no value falls from 1 to 0 around the threshold, half of it within about two widths."""

    name: ClassVar[str] = "amplitude_dropout"
    key: ClassVar[str] = "N10"
    formula: ClassVar[str] = "P(missing) = 1 / (1 + exp((A - ir_threshold) / width))"
    variables: ClassVar[tuple[str, ...]] = ("amplitude",)

    ir_threshold: Value = parameter(
        "count",
        (0, 1e6),
        "amplitude at which every other value is missing; 0 for none",
        "libfreenect2: thresholds 3 and 10 of its own scale",
        typical=30.0,
    )
    width: Value = parameter(
        "count", (0, 1e6), f"of the step; 0 for a hard one, {HARD:.0%} of the threshold", "logistic", typical=6.0
    )

    def dropout(self, depth: Image, view: View) -> Image:
        if view.ir is None or not np.any(self.ir_threshold):
            return np.zeros((), depth.dtype)
        threshold, width = np.asarray(self.ir_threshold, depth.dtype), np.asarray(self.width, depth.dtype)
        width = np.where(width > 0, width, np.maximum(HARD * threshold, np.finfo(depth.dtype).tiny))
        missing = (np.asarray(view.ir, depth.dtype) - threshold) / width
        with np.errstate(over="ignore"):  # far above the threshold nothing is missing
            np.exp(missing, out=missing)
        missing += 1
        np.divide(1, missing, out=missing)
        # a threshold of 0 is none; a pixel of unknown amplitude is not judged
        return np.where(threshold > 0, np.nan_to_num(missing, copy=False), 0).astype(depth.dtype, copy=False)

    def loses_with(self, depth: Image, view: View) -> Image | None:
        """One over the light that comes back from the lamp's distance and direction, where nobody recorded it."""
        if view.ir is not None:
            return None
        incidence = 0.0 if view.incidence is None else np.nan_to_num(np.asarray(view.incidence, depth.dtype))
        seen = 1.0 if view.reflectance is None else np.nan_to_num(np.asarray(view.reflectance, depth.dtype), nan=1.0)
        lit = np.maximum(np.cos(incidence), DIM) * np.maximum(seen, DIM)
        return np.asarray((depth * view.stretch) ** 2 / lit, depth.dtype)
