"""How far an exported model is from the own one: frontal walls, depth by depth."""

from dataclasses import dataclass, replace

import numpy as np

from fusion.geometry.camera import Camera
from fusion.recording.cameras.presets import PRESETS
from fusion.sensor.moment import Moment
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image
from fusion.simulation.exporting.target import Floats, Parameters, SimulatorTarget, StatedWall
from fusion.simulation.ideal.frame import IdealFrame
from fusion.simulation.ideal.sense import stated_by
from fusion.simulation.ideal.view import view_of_ideal
from fusion.simulation.rendering.light_level import with_light_level
from fusion.simulation.simulate import USUAL_CAMERA

DEPTHS = (0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0)  # [m]
# walls around each depth [5 %], by the golden ratio: waves and steps are met at all their phases, whatever their period
NEIGHBOURHOOD = (0.618034 * np.arange(9)) % 1 - 0.5
WIDTH = 32  # [px] of the image that is looked at
REFLECTANCE = 0.8  # of the wall: white paint, guess


@dataclass(frozen=True)
class Loss:
    """What is lost."""

    depths: Floats  # (n,) [m]
    own: Floats  # (n, 2) mean error and spread [m] over the image, as the model states them
    exported: Floats  # (n, 2) those of the other simulator's law
    # (n,) [m] distance of both: the root of the mean over pixels of (mean - mean)^2 + (spread - spread)^2, which of two
    # normal distributions is the Wasserstein distance
    rms: Floats
    whole: Floats  # (n,) [m] the same with nothing exported at all
    # effect of the own model to the rms (n,) [m] of what it does alone; NaN where it leaves no value
    effects: dict[str, Floats]
    lost: tuple[str, ...]  # effects that the other law does not know


def stated(sensor: Sensor, camera: Camera) -> StatedWall:
    """What a sensor model says of frontal white walls, over a coarse image."""
    walls = [_wall(sensor, camera, depth) for depth in DEPTHS]
    bias, sigma = (np.stack([wall[k] for wall in walls]) for k in (0, 1))
    depths = np.array(DEPTHS)
    return StatedWall(depths, depths[:, None] * (1 + 0.05 * NEIGHBOURHOOD), bias, sigma)


def loss_of(sensor: Sensor, camera: Camera, target: SimulatorTarget, given: Parameters) -> Loss:
    """The table of what is lost on the way to another simulator."""
    own = stated(sensor, camera)
    pixels = own.bias.shape[1] // own.at.shape[1]
    bias, sigma = (np.repeat(values, pixels, axis=1) for values in target.moments(given, own.at))
    there = target.moments(given, own.depths)
    alone = {e.name: replace(sensor, effects=_with_light(sensor, e), left_out=()) for e in sensor.effects}
    effects = {name: _size(stated(one, camera), stated(_light_only(one, name), camera)) for name, one in alone.items()}
    return Loss(
        own.depths,
        np.column_stack([own.mean_bias, own.rms_sigma]),
        np.column_stack(there),
        _rms(own.bias - bias, own.sigma - sigma),
        _rms(own.bias, own.sigma),
        effects,
        tuple(name for name in effects if name not in target.carried),
    )


def usual_camera(sensor: Sensor) -> Camera:
    """The camera of that name where none is given, or else one of the sensor's principle."""
    known = (camera for name, (camera, _) in PRESETS.items() if f"{sensor.name}-".startswith(f"{name}-"))
    by_principle = PRESETS[USUAL_CAMERA.get(sensor.principle, "primesense")][0]
    return stated_by(next(known, by_principle), sensor)


def _wall(sensor: Sensor, camera: Camera, depth: float) -> tuple[Floats, Floats]:
    """Mean error and spread (pixels x walls,) [m] around a depth; quantities that walls share are their own."""
    small = camera.resized(WIDTH, max(1, round(WIDTH * camera.height / camera.width)))
    sensor = with_light_level(sensor)
    parts = []
    for share in NEIGHBOURHOOD:
        wall = np.full(small.shape, depth * (1 + 0.05 * share), np.float32)
        parts.append(_repeated(sensor, camera, small, wall))
    bias, sigma = (np.concatenate([part[k].ravel() for part in parts]) for k in (0, 1))
    return bias, sigma


def _repeated(sensor: Sensor, camera: Camera, small: Camera, wall: Image) -> tuple[Image, Image]:
    """What is said in pixels counts in those of the whole image, so the disparity is computed with its focal length."""
    # of one unit, so that what differs between units is there
    view = view_of_ideal(IdealFrame(wall, reflectance=REFLECTANCE, moment=Moment(unit=0, placement=0)), small, sensor)
    # effects take disparity from fx and baseline: a longer baseline stands for the finer pixels
    scaled = replace(sensor, baseline=sensor.baseline * camera.fx / small.fx)
    with np.errstate(all="ignore"):
        view = replace(view, ir=sensor.amplitude(view))
        mean, sigma = scaled.repeated(wall, replace(view, baseline=scaled.baseline))
        missing = sensor.dropout(wall, view) > 0.5
    bias = np.where(missing, np.nan, mean - wall)
    return np.broadcast_to(bias, wall.shape), np.where(np.isfinite(bias), sigma, np.nan)


def _rms(bias: Floats, sigma: Floats) -> Floats:
    both = bias**2 + sigma**2
    count = np.isfinite(both).sum(axis=1)
    return np.where(count > 0, np.sqrt(np.nansum(both, axis=1) / np.maximum(count, 1)), np.nan)


def _size(one: StatedWall, none: StatedWall) -> Floats:
    return _rms(one.bias - none.bias, np.sqrt(np.maximum(one.sigma**2 - none.sigma**2, 0)))


def _with_light(sensor: Sensor, effect: object) -> tuple:
    """An effect alone, with what makes the light that it may need."""
    return tuple(e for e in sensor.effects if e is effect or e.name == "illumination_vignetting")


def _light_only(sensor: Sensor, name: str) -> Sensor:
    kept = tuple(e for e in sensor.effects if e.name != name)
    return replace(sensor, effects=kept, left_out=())
