"""Sensors known by name, one file per maker's family, every number with its source."""

from collections.abc import Callable

from fusion.errors import SensorError
from fusion.geometry.camera import Camera
from fusion.sensor.presets.azure import azure_kinect
from fusion.sensor.presets.kinect_v1 import kinect_v1
from fusion.sensor.presets.kinect_v2 import kinect_v2_indoors, kinect_v2_overcast, kinect_v2_sunlight
from fusion.sensor.presets.realsense import realsense_d435
from fusion.sensor.sensor import Sensor

PRESETS: dict[str, Callable[[], Sensor]] = {
    "kinect-v1": kinect_v1,
    "kinect-v2-indoors": kinect_v2_indoors,
    "kinect-v2-overcast": kinect_v2_overcast,
    "kinect-v2-sunlight": kinect_v2_sunlight,
    "realsense-d435": realsense_d435,
    "azure-kinect": azure_kinect,
}
# what a sensor of that principle is taken for when nothing else is known
_USUAL = {"structured_light": "kinect-v1", "itof": "kinect-v2-indoors", "active_stereo": "realsense-d435"}
_KINDS = {
    "structured_light": "structured-light sensor", "itof": "time-of-flight sensor",
    "active_stereo": "stereo sensor with a projector",
}  # fmt: skip
# a unit's own errors and the light it needs are not known from its principle; its noise is about right
_NOISE = ("lateral_noise", "axial_noise")


def preset(name: str) -> Sensor:
    """The sensor of that name; SensorError when there is none."""
    if name not in PRESETS:
        raise SensorError(
            "no such sensor", found=name, expected="a sensor.json or one of " + ", ".join(PRESETS), do="check --sensor"
        )
    return PRESETS[name]()


def default_sensor(camera: Camera) -> Sensor:
    """What to assume about a camera of which only the principle is known: noise and rounding; said in `warnings`."""
    known = preset(_USUAL.get(camera.principle, "kinect-v1"))
    # rounding is left out where not even the principle is known: it would be an invention
    wanted = (*_NOISE, "depth_quantization") if camera.principle in _USUAL else _NOISE
    effects = tuple(effect for effect in known.effects if effect.name in wanted)
    sources = {effect.name: known.sources[effect.name] for effect in effects}
    kind = _KINDS.get(camera.principle, "depth sensor")
    warning = f"no sensor model given: the usual noise of a {kind} is assumed (that of the preset {known.name})"
    if camera.principle not in _USUAL:
        sources = dict.fromkeys(sources, "guess: the sensor's principle is not known")
        return Sensor("guess", "unknown", effects, sources=sources, warnings=(warning,))
    return Sensor(
        known.name,
        known.principle,
        effects,
        camera.sensor,
        camera.serial,
        known.baseline,
        sources=sources,
        warnings=(warning,),
    )
