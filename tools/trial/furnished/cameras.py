"""Sensors and their cameras, drawn; and what a sensor file may tell of them."""

from collections.abc import Collection
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter

from tools.trial.furnished.physics.lens import StatedCamera
from tools.trial.furnished.physics.sensor import C, SensorNumbers

Rng = np.random.Generator
Told = dict[str, Any]
REFERENCE = 1000.0  # [counts] at which the noise of time of flight is told
FREQUENCIES = [[20e6], [16e6], [80e6, 60e6], [100e6, 20e6], [100e6, 80e6], [120e6, 80e6, 16e6]]
SIZES = [(160, 120), (160, 120), (320, 240)]
PRINCIPLES = {"itof": "itof", "zone": "itof", "sl": "structured_light", "stereo": "active_stereo"}


def drawn(rng: Rng, kind: str, size: tuple[int, int] | None = None) -> tuple[SensorNumbers, StatedCamera]:
    """A sensor of the `kind` itof, zone, sl or stereo, and its camera as stated; `size` (width, height), else drawn."""
    zone, by_flight = kind == "zone", kind in ("itof", "zone")
    if zone:
        width, height = [(32, 24), (8, 8)][rng.integers(2)]
        view = rng.uniform(45, 62)
    else:
        width, height = size or SIZES[rng.integers(3)]
        view = rng.uniform(52, 78)
    f = width / 2 / np.tan(np.radians(view / 2))
    fx, fy = round(f, 4), round(f * rng.choice([1, rng.uniform(0.97, 1.03)]), 4)
    cx = round((width - 1) / 2 + rng.normal(0, 0.012 * width), 4)
    cy = round((height - 1) / 2 + rng.normal(0, 0.012 * height), 4)
    distorted = rng.random() < 0.5
    k1 = rng.uniform(-0.15, 0.1)
    distortion = [0.0] * 5
    if distorted and not zone:
        distortion = [k1, -0.35 * k1 * rng.uniform(0, 1), rng.normal(0, 8e-4), rng.normal(0, 8e-4), 0.0]
    scale = float(rng.choice([1000, 4000, 5000, 10000]) if by_flight else rng.choice([5000, 10000]))
    rounded = tuple(round(x, 6) for x in distortion)
    camera = StatedCamera(width, height, fx, fy, cx, cy, rounded, scale, PRINCIPLES[kind])
    if by_flight:
        return _flight(rng, kind, camera), camera
    return _triangulating(rng, kind, camera, f), camera


def _flight(rng: Rng, kind: str, camera: StatedCamera) -> SensorNumbers:
    taps, falloff = int(rng.choice([3, 4])), float(rng.choice([1, 2, 3, 4]))
    counts, shot = float(rng.uniform(2500, 9000)), float(rng.uniform(1.3, 2.2))
    frequencies = FREQUENCIES[rng.integers(6)]
    sensor = SensorNumbers(True, kind, 7.5, taps, falloff, counts, shot, list(frequencies))
    if len(frequencies) > 1:
        sensor.range_max = 7.4
    # electrons of a count, by the noise at 2 m of a reflectance of 0.6 on the axis
    wanted = rng.uniform(0.002, 0.006) if len(frequencies) == 1 else rng.uniform(0.0012, 0.004)
    seen = counts * 0.6 / 4
    squared = (C / 4 / np.pi) ** 2 / sum(x * x for x in frequencies)
    sensor.electrons = squared * 2 / taps * shot / (wanted**2 * seen) * 1.25
    sensor.ambient = float(0.25 * shot * sensor.electrons * seen * rng.uniform(0.3, 1.5))
    if kind == "zone":
        sensor.fill = float(rng.choice([0, 1.0]))
        sensor.parts = 8 if camera.height == 8 else 5
    elif rng.random() < 0.3 and camera.width == 160:
        sensor.fill, sensor.parts = 1.0, 3
    if camera.scale == 1000:
        sensor.step_m = 0.001
    return sensor


def _triangulating(rng: Rng, kind: str, camera: StatedCamera, f: float) -> SensorNumbers:
    width = camera.width
    sensor = SensorNumbers(False, kind)
    sensor.baseline = round(float(rng.choice([-1, 1]) * rng.uniform(0.045, 0.11)), 4)
    sensor.step_px = float(rng.choice([1 / 32, 1 / 64])) * (width / 320)
    sensor.sigma_px = round(float(rng.uniform(0.04, 0.09)) * width / 640, 5)
    sensor.correlation_px = float(rng.choice([0, 1.5, 2.5]))
    sensor.pixel_metres = f * abs(sensor.baseline)
    if sensor.correlation_px:
        white = np.random.default_rng(0).standard_normal((400, 400))
        sensor.spread = float(gaussian_filter(white, sensor.correlation_px / 2, mode="wrap").std())
    if rng.random() < 0.35 and kind == "sl":
        sensor.speckle = (round(float(rng.uniform(0.01, 0.03)) * width / 320, 5), 4.0)
    return sensor


def sensor_file(sensor: SensorNumbers, camera: StatedCamera, name: str, without: Collection[str]) -> Told:
    """The content of sensor.json, without the effects that are concealed."""
    told = _told_of_flight(sensor) if sensor.flight else _told_of_matching(sensor)
    effects = [one for one in told if one["effect"] not in without]
    head = {"format": "fusion-sensor/1", "name": name, "principle": camera.principle, "sensor": name}
    return {**head, "effects": effects}


def _told_of_flight(sensor: SensorNumbers) -> list[Told]:
    squares = sum(f * f for f in sensor.frequencies)
    metres = C / 4 / np.pi / np.sqrt(squares)
    light = sensor.electrons * REFERENCE
    shot = metres * np.sqrt(2 / sensor.taps * sensor.shot / light)
    floor = metres * np.sqrt(2 / sensor.taps * sensor.ambient) / light
    lamp = {"exponent": _number(sensor.falloff, "1", 0.02)}
    lamp["ir_at_1m"] = _number(sensor.counts, "count", 0.01 * sensor.counts)
    out = [_effect("illumination_vignetting", lamp, "lamp profile as measured")]
    if sensor.fill:
        area = {"fill": _number(sensor.fill, "1", 0)}
        out.append(_effect("mixed_pixels", area, "a pixel collects over its whole area"))
    noise = {"shot": _number(shot, "m", 0.03 * shot), "floor": _number(floor, "m", 0.05 * floor)}
    noise["ir_reference"] = _number(REFERENCE, "count", 0)
    out.append(_effect("axial_noise", noise, "shot noise of the raw taps"))
    if sensor.dropout:
        threshold, width = sensor.dropout
        weak = {"ir_threshold": _number(threshold, "count", 0.02 * threshold)}
        weak["width"] = _number(width, "count", 0.1 * width)
        out.append(_effect("amplitude_dropout", weak, "threshold of the firmware"))
    if sensor.step_m:
        out.append(_effect("depth_quantization", {"step": _number(sensor.step_m, "m", 0)}, "integer millimetres"))
    return out


def _told_of_matching(sensor: SensorNumbers) -> list[Told]:
    where = {"baseline": _number(sensor.baseline, "m", 0.0002)}
    out = [_effect("projector_shadow", where, "projector on the camera x axis")]
    noise = {"sigma_px": _number(sensor.sigma_px, "px", 0.05 * sensor.sigma_px)}
    if sensor.correlation_px:
        noise["correlation_px"] = _number(sensor.correlation_px, "px", 0.5)
    out.append(_effect("axial_noise", noise, "noise of the disparity per frame"))
    if sensor.speckle:
        sigma, length = sensor.speckle
        still = {"sigma_px": _number(sigma, "px", 0.1 * sigma), "correlation_px": _number(length, "px", 1.0)}
        out.append(_effect("speckle_noise", still, "frozen in a static scene"))
    if sensor.window:
        out.append(_effect("edge_fattening", {"window_px": _number(sensor.window, "px", 0.5)}, "matching window"))
    out.append(_effect("depth_quantization", {"step_px": _number(sensor.step_px, "px", 0)}, "sub-pixel steps"))
    return out


def _effect(name: str, parameters: Told, source: str) -> Told:
    return {"effect": name, "parameters": parameters, "source": source}


def _number(value: float, unit: str, std: float) -> Told:
    return {"value": value, "unit": unit, "std": std}
