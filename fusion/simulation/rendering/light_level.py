"""How much light comes back: the infrared image, and the amplitude where a model does not say it."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.effects.light.illumination_vignetting import IlluminationVignetting
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image, View

BRIGHT = 0.8  # reflectance of the walls on which noise is usually measured as c0 + c1 z + c2 z^2: guess
DISTANCES = np.linspace(0.7, 3.0, 24)  # [m]


def with_light_level(sensor: Sensor) -> Sensor:
    """The sensor with `ir_at_1m` where it has noise by distance and by amplitude, but not the amplitude itself.

    The noise of a bright wall is c0 + c1 z + c2 z^2 at each distance, and sqrt(shot^2 q + floor^2 q^2) with
    q = ir_reference / amplitude: that tells the amplitude there, and amplitude times z^2 is the same for all z.
    """
    noise, lamp = sensor.effect("axial_noise"), sensor.effect("illumination_vignetting")
    lamp = IlluminationVignetting() if lamp is None else lamp
    if not isinstance(noise, AxialNoise) or not isinstance(lamp, IlluminationVignetting) or np.any(lamp.ir_at_1m):
        return sensor
    values = (noise.c0, noise.c1, noise.c2, noise.shot, noise.floor, noise.ir_reference)
    c0, c1, c2, shot, floor, reference = (float(np.mean(value)) for value in values)
    sigma = c0 + c1 * DISTANCES + c2 * DISTANCES**2
    usable = sigma > 0
    if not usable.any() or not reference or not (shot or floor):
        return sensor
    q = _darkness(sigma[usable], shot, floor)
    level = float(np.median(reference / q * DISTANCES[usable] ** 2)) / BRIGHT
    lamp = replace(lamp, ir_at_1m=min(level, 1e7))
    others = tuple(effect for effect in sensor.effects if effect.name != lamp.name)
    return replace(
        sensor,
        effects=(*others, lamp),
        warnings=(*sensor.warnings, f"the light level is not given: {level:.0f} counts, where both noise laws agree"),
    )


def _darkness(sigma: np.ndarray, shot: float, floor: float) -> np.ndarray:
    """q of shot^2 q + floor^2 q^2 = sigma^2."""
    if floor == 0:
        return sigma**2 / shot**2
    # the root that is 0 without noise, in a form that does not cancel
    return 2 * sigma**2 / (shot**2 + np.sqrt(shot**4 + 4 * floor**2 * sigma**2))


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
