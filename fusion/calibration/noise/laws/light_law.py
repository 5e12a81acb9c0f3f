"""Noise over ambient light: between laws that were measured in a room, under clouds and in the sun."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.sensor.effects.light.ambient_light import FILLED_BY, AmbientLight, added_noise
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.presets import PRESETS, preset
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View

Array = NDArray[np.floating]

ROOM_LUX = 300.0  # an indoor law is one of about this light: a lit room
# [lux] nominal, lowest and highest light in which Fankhauser measured the two outdoor laws
OVERCAST, SUN = (6_000.0, 1_000.0, 12_000.0), (90_000.0, 85_000.0, 95_000.0)
MOST_LUX = 150_000.0  # brighter than any sun
GUESSED = 2.0  # factor by which a light law that nobody measured on this sensor may be off


@dataclass(frozen=True)
class LightLaw:
    """Variance of one depth over distance, tilt and ambient light."""

    text: str  # where it comes from
    # (depth (n,), tilt (n,), nominal lux (m,) or a number) to (m, n) or (n,) [m^2]
    variance: Callable[[Array, Array, Array | float], Array]
    missing: Callable[[Array, Array, float], Array]  # (depth, tilt, lux) to (n,) shares of values that one light drowns
    # (k, m) what m nominal lights [lux] may be, in k equally likely ways: the laws' own light is not known exactly
    readings: Callable[[Array], Array]
    own: bool  # whether the noise without the light is known for this very unit


def light_law(sensor: Sensor | None, camera: Camera) -> LightLaw | None:
    """The law for a sensor: that of the Kinect v2 between its three presets, else the ambient_light effect on top of
    the sensor's own noise; None when nothing is known of its noise."""
    effect = None if sensor is None else sensor.effect("axial_noise")
    # a law that was measured in other light holds that light already
    own = effect is not None and sensor is not None and sensor.name not in PRESETS and not _in_light(sensor)
    if _is_kinect_v2(sensor, camera):
        return _between_presets(sensor if own else None, camera)
    if effect is None or sensor is None:
        return None
    return _by_effect(sensor, camera, own)


def effective(lux: Array) -> Array:
    """Light in units in which it adds variance: shot noise, and shorter exposures beyond 1 klx.

    With it one line goes through the variances of all three of Fankhauser's laws at 1 m: from overcast to sun light
    grows 15 times and the added variance some 200 times, far more than shot noise alone would make it.
    """
    return np.asarray(lux * (1.0 + np.asarray(lux) / FILLED_BY))


def _between_presets(own: Sensor | None, camera: Camera) -> LightLaw:
    names = ("kinect-v2-indoors", "kinect-v2-overcast", "kinect-v2-sunlight")
    room, clouds, sun = (_axial(preset(name)) for name in names)
    base = None if own is None else _axial(own)

    def variance(depth: Array, tilt: Array, lux: Array | float) -> Array:
        dark, grey, bright = (_variance(effect, depth, tilt, camera, 0.0) for effect in (room, clouds, sun))
        grey = np.maximum(grey, dark)
        bright = np.maximum(bright, grey)
        known = dark if base is None else _variance(base, depth, tilt, camera, 0.0)
        at = effective(np.asarray(lux))[..., None]
        low, middle, high = (float(effective(np.asarray(x))) for x in (ROOM_LUX, OVERCAST[0], SUN[0]))
        first = np.clip((at - low) / (middle - low), 0.0, 1.0)
        second = np.maximum((at - middle) / (high - middle), 0.0)
        return np.asarray(known + first * (grey - dark) + second * (bright - grey))

    def readings(nominal: Array) -> Array:
        low = float(effective(np.asarray(ROOM_LUX)))
        middle, high = (float(effective(np.asarray(x[0]))) for x in (OVERCAST, SUN))
        at = effective(nominal)
        ways = []
        for clouds_lux in np.geomspace(OVERCAST[1], OVERCAST[2], 12):
            for sun_lux in np.linspace(SUN[1], SUN[2], 3):
                own_light = (float(effective(np.asarray(x))) for x in (clouds_lux, sun_lux))
                grey, bright = own_light
                first, second = (at - low) / (middle - low), (at - middle) / (high - middle)
                light = np.where(at <= middle, low + first * (grey - low), grey + second * (bright - grey))
                ways.append(_lux_of(np.maximum(light, 0.0)))
        return np.array(ways)

    text = "between Fankhauser's laws for a room, an overcast sky (1 to 12 klx) and direct sun (85 to 95 klx)"
    return LightLaw(text, variance, lambda z, t, lux: _missing(z, t, lux, camera), readings, own is not None)


def _by_effect(sensor: Sensor, camera: Camera, own: bool) -> LightLaw:
    effect = _axial(sensor)

    def variance(depth: Array, tilt: Array, lux: Array | float) -> Array:
        view = replace(_view(depth, tilt, camera), baseline=sensor.baseline * camera.fx / 1e6)
        more = added_noise(0.0, np.maximum(np.asarray(lux)[..., None] - ROOM_LUX, 0.0), depth[None, :], view)
        return np.asarray(
            _variance(effect, depth, tilt, camera, sensor.baseline) + more.reshape(*np.shape(lux), -1) ** 2
        )

    def readings(nominal: Array) -> Array:
        factors = np.exp(np.linspace(-1.5, 1.5, 13) * np.log(GUESSED) / 1.5)
        return np.asarray(factors[:, None] * nominal)

    text = "the ambient_light effect on top of the sensor's own noise; its size is a guess for this sensor"
    return LightLaw(text, variance, lambda z, t, lux: _missing(z, t, lux, camera), readings, own)


def _lux_of(light: Array) -> Array:
    """The inverse of `effective`."""
    return np.asarray(0.5 * FILLED_BY * (np.sqrt(1.0 + 4.0 * light / FILLED_BY) - 1.0))


def _in_light(sensor: Sensor) -> bool:
    light = sensor.effect("ambient_light")
    return isinstance(light, AmbientLight) and not np.any(light.noise_share)


def _is_kinect_v2(sensor: Sensor | None, camera: Camera) -> bool:
    names = [camera.sensor, *((sensor.name, sensor.sensor) if sensor is not None else ())]
    return any("kinect" in name.lower() and "v2" in name.lower() for name in names)


def _axial(sensor: Sensor) -> AxialNoise:
    effect = sensor.effect("axial_noise")
    assert isinstance(effect, AxialNoise)
    return effect


def _variance(effect: AxialNoise, depth: Array, tilt: Array, camera: Camera, baseline: float) -> Array:
    view = _view(depth, tilt, camera)
    if baseline:
        view = replace(view, baseline=baseline * camera.fx / view.camera.fx)
    return np.asarray(effect.noise(depth[None, :], view)[0] ** 2)


def _missing(depth: Array, tilt: Array, lux: float, camera: Camera) -> Array:
    light = AmbientLight(ambient=max(lux - ROOM_LUX, 0.0))
    return np.broadcast_to(light.dropout(depth[None, :], _view(depth, tilt, camera)), (1, len(depth)))[0]


def _view(depth: Array, tilt: Array, camera: Camera) -> View:
    """Pixels on the axis, side by side."""
    row = Camera(len(depth), 1, 1e6, 1e6, 0.0, 0.0, principle=camera.principle)
    return View(row, depth[None, :], tilt[None, :])
