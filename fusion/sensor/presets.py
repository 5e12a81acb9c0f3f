"""Sensors known by name: `presets.toml` beside this file has their numbers, each with its source."""

import tomllib
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from fusion.errors import SensorError
from fusion.files.schema import one_of
from fusion.geometry.camera import Camera, Principle
from fusion.sensor.catalogue import IMPLEMENTED
from fusion.sensor.sensor import Sensor
from fusion.sensor.working_range import WorkingRange

_TABLES: dict[str, dict[str, Any]] = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
PRESETS = tuple(_TABLES)
# words of a device's name, as its driver or recording states it, and the preset of that device
_DEVICES = {
    "kinect-v1": "kinect-v1",
    "kinect for xbox 360": "kinect-v1",
    "kinect-v2": "kinect-v2-indoors",
    "kinect v2": "kinect-v2-indoors",
    "azure": "azure-kinect",
    "femto bolt": "femto-bolt",
    "femto mega": "femto-bolt",
    "d405": "realsense-d405",
    "d415": "realsense-d415",
    "d435": "realsense-d435",
    "d455": "realsense-d455",
    "l515": "realsense-l515",
    "xtion": "asus-xtion",
    "primesense": "primesense",
    "structure-sensor": "structure-sensor",
    "structure sensor": "structure-sensor",
    "truedepth": "iphone-truedepth",
    "iphone-lidar": "iphone-lidar",
    "oak-d": "oak-d",
}
# what a sensor of that principle is taken for when the device is not known
_USUAL = {
    Principle.STRUCTURED_LIGHT: "kinect-v1",
    Principle.TIME_OF_FLIGHT: "kinect-v2-indoors",
    Principle.ACTIVE_STEREO: "realsense-d435",
}
_KINDS = {
    Principle.STRUCTURED_LIGHT: "structured-light sensor", Principle.TIME_OF_FLIGHT: "time-of-flight sensor",
    Principle.ACTIVE_STEREO: "stereo sensor with a projector",
}  # fmt: skip
# a unit's own errors and the light it needs are not known from its kind; its noise is about right
_NOISE = ("lateral_noise", "axial_noise")


@cache
def preset(name: str) -> Sensor:
    """The sensor of that name; SensorError when there is none."""
    if name not in PRESETS:
        raise SensorError(
            "no such sensor",
            found=name,
            expected="a sensor.json or " + one_of(PRESETS, name),
            do="check --sensor",
        )
    table = dict(_TABLES[name])
    base = preset(table.pop("like")) if "like" in table else Sensor()
    because, without = table.pop("because", ""), table.pop("without", ())
    works = WorkingRange(**table.pop("works")) if "works" in table else base.works
    effects = {effect.name: effect for effect in base.effects if effect.name not in without}
    sources = {effect: base.sources[effect] for effect in effects}
    if because:
        works = replace(works, source=f"{because}; {works.source}")
        sources = {effect: f"{because}; {source}" for effect, source in sources.items()}
    std = dict(base.std)
    for effect in [key for key in table if key in IMPLEMENTED]:
        numbers = dict(table.pop(effect))
        sources[effect] = numbers.pop("source")
        std |= {(effect, parameter): value for parameter, value in numbers.pop("std", {}).items()}
        effects[effect] = replace(effects[effect], **numbers) if effect in effects else IMPLEMENTED[effect](**numbers)
    own: Any = {"effects": tuple(effects.values()), "works": works, "std": std, "sources": sources, "left_out": ()}
    return replace(base, name=name, **own, **table)


def preset_of(device: str) -> str | None:
    """The preset of a device by the name that its driver or recording states; None where there is none.

    >>> preset_of("Intel RealSense D435I"), preset_of("Orbbec Gemini 335")
    ('realsense-d435', None)
    """
    told = device.lower()
    return next((name for word, name in _DEVICES.items() if word in told), None)


def default_sensor(camera: Camera) -> Sensor:
    """What to assume where no model is given: noise and rounding of the device, else of its principle as a guess.

    `warnings` says which; a sensor that is not the preset's own device is called a guess.
    """
    own = preset_of(camera.sensor)
    known = preset(own or _USUAL.get(camera.principle, "kinect-v1"))
    if own:
        what = f"the preset {own} is assumed, which is of this device ({camera.sensor})"
        return _assumed(known, camera, (*_NOISE, "depth_quantization"), what)
    if camera.principle not in _USUAL:
        # rounding is left out where not even the principle is known: it would be an invention
        guess = replace(known, principle=Principle.UNKNOWN)
        return _assumed(
            guess, camera, _NOISE, "a depth sensor is assumed", "guess: the sensor's principle is not known"
        )
    what = f"a {_KINDS[camera.principle]} is assumed (that of the preset {known.name})"
    what += f"; none is known of its own: {camera.sensor}" if camera.sensor else ""
    return _assumed(known, camera, (*_NOISE, "depth_quantization"), what, f"guess: as the preset {known.name}")


def _assumed(known: Sensor, camera: Camera, wanted: tuple[str, ...], what: str, guess: str = "") -> Sensor:
    """Those effects of a preset for a camera; where they are a `guess` they do not bear the preset's name."""
    effects = tuple(effect for effect in known.effects if effect.name in wanted)
    return Sensor(
        "guess" if guess else known.name,
        known.principle,
        effects,
        camera.sensor,
        camera.serial,
        known.baseline,
        sources={effect.name: guess or known.sources[effect.name] for effect in effects},
        warnings=(f"no sensor model given: the usual noise of {what}",),
    )
