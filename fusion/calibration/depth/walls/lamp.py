"""The lamp of a time-of-flight sensor from the infrared images of the walls: how bright it is, and how it fades."""

from dataclasses import replace

import numpy as np

from fusion.calibration.depth.walls.wall import Wall
from fusion.geometry.camera import Camera, Principle
from fusion.sensor.effects.light.illumination_vignetting import IlluminationVignetting
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import stretch

WHITE, WHITE_STD = 0.8, 0.15  # reflectance of a light wall in the infrared: guess
EVERY = 4  # pixels: a wall has plenty
LEAST = 100  # pixels of a wall that tell something


def with_lamp(sensor: Sensor, walls: list[Wall], camera: Camera) -> Sensor:
    """The sensor with its lamp, as far as walls with an infrared image show it; a stated fading stays.

    It tells how much light comes back where a recording has no infrared image. A board's squares tell nothing: how
    dark they are is not known.
    """
    if sensor.principle != Principle.TIME_OF_FLIGHT:
        return sensor
    away, light = [np.zeros(0)], [np.zeros(0)]
    for wall in walls:
        view = wall.view(camera, wall.true_plane.depth(camera))
        if wall.by_board or view.ir is None or view.depth is None or view.incidence is None:
            continue
        use = wall.mask & (view.ir > 0)
        if use.sum() < LEAST:
            continue
        ray = stretch(camera)[use][::EVERY]
        facing = np.cos(view.incidence)[use][::EVERY]
        away.append(-np.log(ray))
        light.append(np.log(view.ir[use][::EVERY] * (view.depth[use][::EVERY] * ray) ** 2 / facing))
    x, y = np.concatenate(away), np.concatenate(light)
    if not x.size:
        return sensor
    known = sensor.effect("illumination_vignetting")
    if isinstance(known, IlluminationVignetting):
        exponent = float(np.mean(known.exponent))
    else:
        exponent = float(np.clip(np.polyfit(x, y, 1)[0], 0, 10))
    bright = float(np.exp(np.median(y - exponent * x))) / WHITE
    lamp = IlluminationVignetting(exponent=exponent, ir_at_1m=bright)
    std = sensor.std | {(lamp.name, "ir_at_1m"): bright * WHITE_STD / WHITE}
    said = f"infrared images of {len(light) - 1} walls, taken to reflect {WHITE:g} of the light: guess"
    return replace(sensor.having(lamp), std=std, sources=sensor.sources | {lamp.name: said})


def ir_reference(walls: list[Wall]) -> float | None:
    """Median amplitude over the walls [count]; None unless every wall has one."""
    found = [float(np.median(w.ir[w.mask])) for w in walls if w.ir is not None and np.any(w.ir[w.mask] > 0)]
    return float(np.median(found)) if len(found) == len(walls) else None


def ir_span(walls: list[Wall]) -> tuple[float, float]:
    """Darkest and brightest amplitude of all walls [count]; usual ones where none is known."""
    found = [w.ir[w.mask & (w.ir > 0)] for w in walls if w.ir is not None]
    every = np.concatenate([ir.ravel() for ir in found]) if found else np.zeros(0)
    low, high = (float(np.min(every)), float(np.max(every))) if every.size else (100.0, 65535.0)
    return low, max(high, 1.01 * low)
