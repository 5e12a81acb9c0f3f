"""What single pixels of a time-of-flight camera keep of error on every wall, beside what their neighbours have too."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from fusion.calibration.depth.laws.choice import less
from fusion.calibration.depth.maps.surface import LEAST_WALLS
from fusion.calibration.depth.walls.plane import plane_through
from fusion.calibration.depth.walls.tiles import side_of
from fusion.calibration.depth.walls.wall import Wall
from fusion.geometry.camera import Camera, Principle
from fusion.sensor.effects.readout.fixed_pattern import FixedPattern
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import stretch

NAME = FixedPattern.name
LEAST = 1e-5  # [m] standard deviation of a mean over frames is never taken smaller
Array = NDArray[np.floating]


@dataclass(frozen=True)
class PixelPattern:
    """An error of each pixel, by walls; `before`, `after`: what single pixels of a wall left out are off by [m]."""

    map: Array  # (h, w) [m] along the ray, 0 where nothing is known
    std: float  # of a usual pixel [m]
    before: float
    after: float

    def added(self, sensor: Sensor) -> Sensor:
        """The sensor with it, beside a map that its law has already."""
        old, more = sensor.effect(NAME), FixedPattern(map=np.asarray(self.map, float))
        if isinstance(old, FixedPattern):
            more = replace(old, map=np.asarray(old.map) + self.map)
        kept = tuple(effect for effect in sensor.effects if effect.name != NAME)
        std = sensor.std | {(NAME, "map"): float(np.hypot(self.std, np.max(sensor.std.get((NAME, "map"), 0.0))))}
        return replace(sensor, effects=(*kept, more), std=std, fitted=sensor.fitted | {NAME}, left_out=())

    @property
    def note(self) -> tuple[str, str]:
        """What was done, in words."""
        text = f"single pixels keep errors of their own ({NAME}): without these they err on a wall left out by "
        return "ok", f"{text}{self.after * 1e3:.2f} mm, with them by {self.before * 1e3:.2f} mm"


def pixel_pattern(walls: Sequence[Wall], sensor: Sensor, camera: Camera) -> PixelPattern | None:
    """By walls that fill the image, of several frames each; None where it does not help on each one that was left out.

    Thousands of pixels differ independently, so what they keep shows on every single wall; the shape of a wall does
    not, as other pixels see it from elsewhere.

    Args:
        walls: as read.
        sensor: with the law of everything smooth.
        camera: calibrated.
    """
    some = [wall for wall in walls if not wall.by_board and wall.frames > 1]
    stated = sensor.effect(NAME) is not None and NAME not in sensor.fitted
    if sensor.principle != Principle.TIME_OF_FLIGHT or len(some) < LEAST_WALLS or stated:
        return None
    rest = np.array([_left(wall, sensor, camera) for wall in some])
    seen = np.isfinite(rest)
    noise = np.array([np.nan_to_num(wall.std**2 / wall.frames, nan=np.inf) for wall in some])
    weight = np.where(seen, 1 / np.maximum(noise, LEAST**2), 0.0)
    rest = np.where(seen, rest, 0.0)
    total, sums = weight.sum(axis=0), (weight * rest).sum(axis=0)
    left = [r - _shrunk(sums - w * r, total - w) for r, w in zip(rest, weight, strict=True)]
    before, after = (
        np.array([float(np.mean(one[here] ** 2)) if here.any() else 0.0 for one, here in zip(every, seen, strict=True)])
        for every in (rest, left)
    )
    if not (less(after, before) and (after < before).all()):
        return None
    std = float(1 / np.sqrt(np.median(total[total > 0])))
    return PixelPattern(_shrunk(sums, total), std, *(float(np.sqrt(x.mean())) for x in (before, after)))


def _left(wall: Wall, sensor: Sensor, camera: Camera) -> Array:
    """(h, w) what each pixel is off along its ray [m] beside its neighbours; NaN where it sees no wall."""
    depth = sensor.correct(wall.measured, wall.view(camera, wall.measured))
    mask = wall.mask & np.isfinite(depth)
    off = np.where(mask, (depth - plane_through(depth, mask, camera).depth(camera)) * stretch(camera), 0.0)
    side = side_of(camera.width)
    around = uniform_filter(off, side) / np.maximum(uniform_filter(mask.astype(float), side), 1e-9)
    return np.where(mask, off - around, np.nan)


def _shrunk(sums: Array, total: Array) -> Array:
    """(h, w) weighted means, drawn to 0 as far as noise makes them; 0 where nothing is known."""
    known = total > 0
    noise = 1 / np.where(known, total, 1.0)
    mean = np.where(known, sums * noise, 0.0)
    own = max(float(np.mean(mean[known] ** 2) - np.mean(noise[known])), 0.0) if known.any() else 0.0
    return np.asarray(np.where(known, mean * own / (own + noise), 0.0))
