"""Amplitude where there is no infrared image: what a surface of usual brightness sends back."""

from dataclasses import replace

import numpy as np

from fusion.sensor.correction.estimate import normals_of
from fusion.sensor.effects.light.illumination_vignetting import IlluminationVignetting
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image, View, incidence_of

USUAL = 0.5  # reflectance: guess; from 0.25 to 1 an error that goes with 1 / IR is halved or more
STEEPEST = np.radians(84.0)  # beyond, the normals of a noisy depth image say nothing


def usual_light(sensor: Sensor, view: View) -> Image | None:
    """Amplitude (h, w) [count] by distance and incidence; None where the model does not know its lamp.

    Where a neighbour is missing, and with it the incidence, the surface counts as frontal; 0 where there is no depth.
    """
    lamp = sensor.effect("illumination_vignetting")
    if view.depth is None or not isinstance(lamp, IlluminationVignetting) or not np.any(lamp.ir_at_1m):
        return None
    with np.errstate(all="ignore"):
        incidence = view.incidence
        if incidence is None:
            incidence = incidence_of(normals_of(view.depth, view.camera), view.camera)
        incidence = np.minimum(np.nan_to_num(incidence), STEEPEST)
        usual = np.full(view.depth.shape, USUAL, np.float32)
        light = sensor.amplitude(replace(view, incidence=incidence, reflectance=usual))
        return None if light is None else np.nan_to_num(light)
