"""Temporal filtering: the sensor mixes each frame with the one before, for less noise and some lag."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class TemporalFiltering(Effect):
    """y_t = (1 - memory) z_t + memory y_(t-1); a pixel without a value before is taken as it is.

    Of the noise, 1 - memory is new in each frame; over a long series its spread falls by
    sqrt((1 - memory) / (1 + memory)), which is what is declared where the frame before is not known.
    """

    name: ClassVar[str] = "temporal_filtering"
    key: ClassVar[str] = "N13"
    formula: ClassVar[str] = "y_t = (1 - memory) z_t + memory y_(t-1)"
    variables: ClassVar[tuple[str, ...]] = ("time", "velocity")
    not_corrected: ClassVar[str] = "undoing the mixing would bring back the noise that it took away"

    memory: Value = parameter("1", (0, 0.99), "share of the previous value", "first-order filter", typical=0.4)

    def bias(self, depth: Image, view: View) -> Image:
        previous = view.moment.previous
        if previous is None or not np.any(self.memory):
            return np.zeros((), depth.dtype)
        lag = np.asarray(previous, depth.dtype) - depth
        return np.asarray(self.memory, depth.dtype) * np.where(np.isfinite(lag), lag, 0)

    def spread(self, sigma: Image, depth: Image, view: View) -> Image:
        memory = np.asarray(self.memory, depth.dtype)
        series = sigma * np.sqrt((1 - memory) / (1 + memory))
        previous = view.moment.previous
        if previous is None:
            return series
        return np.where(np.isfinite(previous), (1 - memory) * sigma, sigma)
