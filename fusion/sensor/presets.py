"""Sensors known by name, every number with its source."""

from collections.abc import Callable

from fusion.errors import SensorError
from fusion.geometry.camera import Camera
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.depth_quantization import DepthQuantization
from fusion.sensor.effects.readout.lateral_noise import LateralNoise
from fusion.sensor.sensor import Sensor

NGUYEN = "Nguyen, Izadi, Lovell 2012, original Kinect in near mode"
SIMKINECT = "github ankurhanda/simkinect: disparity rounded to 1/8 px, baseline 0.075 m"


def kinect_v1() -> Sensor:
    """Kinect for Xbox 360: 0.0012 + 0.0019 (z - 0.4)^2 + 0.0001 z^-0.5 theta^2 / (pi/2 - theta)^2 [m]."""
    return Sensor(
        "kinect-v1",
        "structured_light",
        (
            AxialNoise(c0=0.0012 + 0.0019 * 0.4**2, c1=-2 * 0.0019 * 0.4, c2=0.0019, angle=0.0001, angle_exponent=-0.5),
            LateralNoise(sigma_px=0.8),  # the paper's growth with the angle, 0.035 px at 45 deg, is left out
            DepthQuantization(step_px=1 / 8),
        ),
        sensor="Kinect for Xbox 360",
        baseline=0.075,
        sources={"axial_noise": NGUYEN, "lateral_noise": NGUYEN, "depth_quantization": SIMKINECT},
    )


def kinect_v2_indoors() -> Sensor:
    """Kinect v2 in a room: 1.5 - 0.5 z + 0.3 z^2 + 0.1 z^1.5 theta^2 / (pi/2 - theta)^2 [mm]."""
    axial = AxialNoise(c0=0.0015, c1=-0.0005, c2=0.0003, angle=0.0001, angle_exponent=1.5)
    return _kinect_v2("indoors", axial, LateralNoise(sigma=0.0016), "(1) and (2), edges without shadow")


def kinect_v2_overcast() -> Sensor:
    """Kinect v2 outdoors, 1-12 klx: 2.5 - 0.7 z + 0.9 z^2 + 0.5 z^1.5 theta^2 / (pi/2 - theta)^2 [mm]."""
    axial = AxialNoise(c0=0.0025, c1=-0.0007, c2=0.0009, angle=0.0005, angle_exponent=1.5)
    return _kinect_v2("overcast", axial, LateralNoise(sigma=0.0068), "(4) and (5)")


def kinect_v2_sunlight() -> Sensor:
    """Kinect v2 in direct sun, 85-95 klx: 28 - 38 z + 2 z^2 + 0.3 z^1.5 ... + 42 z^2 cos(alpha) [mm]."""
    axial = AxialNoise(c0=0.028, c1=-0.038, c2=0.002, angle=0.0003, angle_exponent=1.5, sunlight=0.042)
    return _kinect_v2("sunlight", axial, None, "(6), sun from the camera's side")


def active_stereo() -> Sensor:
    """An active stereo camera of the RealSense D435 kind: normal noise of the disparity."""
    return Sensor(
        "active-stereo",
        "active_stereo",
        (AxialNoise(sigma_px=0.08, correlation_px=2.0), LateralNoise(sigma_px=0.8)),
        baseline=0.05,
        sources={
            "axial_noise": "guess, a well textured target; baseline 0.05 m: RealSense D435 data sheet",
            "lateral_noise": "guess, as the original Kinect",
        },
    )


PRESETS: dict[str, Callable[[], Sensor]] = {
    "kinect-v1": kinect_v1,
    "kinect-v2-indoors": kinect_v2_indoors,
    "kinect-v2-overcast": kinect_v2_overcast,
    "kinect-v2-sunlight": kinect_v2_sunlight,
    "active-stereo": active_stereo,
}


def preset(name: str) -> Sensor:
    """The sensor of that name; SensorError when there is none."""
    if name not in PRESETS:
        raise SensorError(
            "no such sensor", found=name, expected="a sensor.json or one of " + ", ".join(PRESETS), do="check --sensor"
        )
    return PRESETS[name]()


def default_sensor(camera: Camera) -> Sensor:
    """What to assume about a camera of which only the principle is known; says so in `warnings`."""
    names = {"structured_light": "kinect-v1", "itof": "kinect-v2-indoors", "active_stereo": "active-stereo"}
    known = preset(names.get(camera.principle, "kinect-v1"))
    guessed = f"no sensor model given: the noise of {known.name} is assumed"
    if camera.principle not in names:
        # a Kinect-like noise is a guess; its rounding would be an invention
        effects = tuple(effect for effect in known.effects if effect.name != "depth_quantization")
        sources = dict.fromkeys(("axial_noise", "lateral_noise"), "guess: the sensor's principle is not known")
        return Sensor("guess", "unknown", effects, sources=sources, warnings=(guessed,))
    return Sensor(
        known.name,
        known.principle,
        known.effects,
        camera.sensor,
        camera.serial,
        known.baseline,
        sources=known.sources,
        warnings=(guessed,),
    )


def _kinect_v2(light: str, axial: AxialNoise, lateral: LateralNoise | None, equations: str) -> Sensor:
    source = f"Fankhauser et al. 2015, equations {equations}"
    effects = (axial,) if lateral is None else (axial, lateral)
    sources = {effect.name: source for effect in effects}
    return Sensor(f"kinect-v2-{light}", "itof", effects, sensor="Kinect v2", sources=sources)
