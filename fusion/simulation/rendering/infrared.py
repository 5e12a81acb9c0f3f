"""The infrared image that a sensor gives along with its depth."""

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image, View

LARGEST = 65535  # [count] of a 16-bit image
# guess, for sensors that do not derive depth from this light: shot noise of one count per count, and 2 of the readout
READ_NOISE = 2.0


def infrared(view: View, sensor: Sensor, rng: np.random.Generator) -> NDArray[np.uint16] | None:
    """One image (h, w) [count] of a view that holds the amplitude `ir`; 0 where nothing sends light back.

    In a time-of-flight sensor phase and amplitude come from the same samples, so that sigma_A / A = sigma_phase =
    sigma_range 4 pi f / c (Lange and Seitz, Solid-state time-of-flight range camera, 2001).
    """
    if view.ir is None or view.depth is None:
        return None
    light = np.nan_to_num(view.ir)
    counts = rng.standard_normal(light.shape, dtype=np.float32)
    counts *= _spread(light, view, sensor)
    counts += light
    np.rint(counts, out=counts)
    return np.clip(counts, 0, LARGEST, out=counts).astype(np.uint16)


def _spread(light: Image, view: View, sensor: Sensor) -> Image:
    if not view.time_of_flight:
        return np.sqrt(light + READ_NOISE**2)
    axial = sensor.effect("axial_noise")
    if axial is None or view.depth is None:
        return np.zeros((), light.dtype)
    sigma = axial.noise(view.depth, view) * view.stretch
    phase = np.minimum(np.nan_to_num(sigma) * (2 * np.pi / view.wavelength), 1.0)
    return np.where(light > 0, light * phase, READ_NOISE)
