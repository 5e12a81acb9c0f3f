"""A sensor model for a part of the image, and the part of the image that a pixel stands for."""

from dataclasses import replace
from typing import Any

import numpy as np

from fusion.geometry.camera import Camera
from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View


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


def widest_window(sensor: Sensor, camera: Camera) -> float:
    """Side [px] of the largest square that is matched as one; 1 without."""
    sides = [float(effect.window(View(camera, baseline=sensor.baseline))) for effect in sensor.effects]
    return max([1.0, *(w for w in sides if w < max(camera.shape) / 4)])  # wider ones shake the whole image
