"""Sensors known by name, one file per maker's family, every number with its source."""

from collections.abc import Callable
from dataclasses import replace

from fusion.errors import SensorError
from fusion.files.schema import one_of
from fusion.geometry.camera import Camera
from fusion.geometry.principle import Principle
from fusion.sensor.presets.azure import azure_kinect, femto_bolt
from fusion.sensor.presets.kinect_v1 import kinect_v1
from fusion.sensor.presets.kinect_v2 import kinect_v2_indoors, kinect_v2_overcast, kinect_v2_sunlight
from fusion.sensor.presets.others import iphone_lidar, oak_d
from fusion.sensor.presets.primesense import asus_xtion, iphone_truedepth, primesense, structure_sensor
from fusion.sensor.presets.realsense import (
    realsense_d405,
    realsense_d415,
    realsense_d435,
    realsense_d455,
    realsense_l515,
)
from fusion.sensor.sensor import Sensor

PRESETS: dict[str, Callable[[], Sensor]] = {
    "kinect-v1": kinect_v1,
    "kinect-v2-indoors": kinect_v2_indoors,
    "kinect-v2-overcast": kinect_v2_overcast,
    "kinect-v2-sunlight": kinect_v2_sunlight,
    "azure-kinect": azure_kinect,
    "femto-bolt": femto_bolt,
    "realsense-d405": realsense_d405,
    "realsense-d415": realsense_d415,
    "realsense-d435": realsense_d435,
    "realsense-d455": realsense_d455,
    "realsense-l515": realsense_l515,
    "asus-xtion": asus_xtion,
    "primesense": primesense,
    "structure-sensor": structure_sensor,
    "iphone-truedepth": iphone_truedepth,
    "iphone-lidar": iphone_lidar,
    "oak-d": oak_d,
}
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


def preset(name: str) -> Sensor:
    """The sensor of that name; SensorError when there is none."""
    if name not in PRESETS:
        raise SensorError(
            "no such sensor",
            found=name,
            expected="a sensor.json or " + one_of(list(PRESETS), name),
            do="check --sensor",
        )
    return PRESETS[name]()


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
