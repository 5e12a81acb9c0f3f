"""A sensor model for a part of the image."""

from dataclasses import replace
from typing import Any

import numpy as np

from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor


def of_window(sensor: Sensor, shape: tuple[int, int], window: tuple[slice, slice]) -> Sensor:
    """The sensor whose maps (height, width) are cut to a window of the image; for noise and dropout.

    Laws of the pixel's place in the image, as of bands or a warped pattern, hold for whole images only.
    """
    effects = []
    for effect in sensor.effects:
        maps: dict[str, Any] = {
            name: np.ascontiguousarray(value[window])
            for name, about in parameters(effect).items()
            if about.kind in ("number", "map") and np.shape(value := getattr(effect, name)) == shape
        }
        effects.append(replace(effect, **maps) if maps else effect)
    return replace(sensor, effects=tuple(effects))
