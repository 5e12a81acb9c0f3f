"""Kinect v2: time of flight, as Fankhauser et al. 2015 measured it in a room, under clouds and in the sun."""

from dataclasses import replace

from fusion.geometry.principle import Principle
from fusion.sensor.effect import Effect
from fusion.sensor.effects.light.ambient_light import AmbientLight
from fusion.sensor.effects.light.illumination_vignetting import IlluminationVignetting
from fusion.sensor.effects.phase.amplitude_error import AmplitudeError
from fusion.sensor.effects.phase.cyclic_error import CyclicError
from fusion.sensor.effects.phase.mixed_pixels import MixedPixels
from fusion.sensor.effects.readout.amplitude_dropout import AmplitudeDropout
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.depth_quantization import DepthQuantization
from fusion.sensor.effects.readout.lateral_noise import LateralNoise
from fusion.sensor.effects.readout.saturation import Saturation
from fusion.sensor.sensor import Sensor
from fusion.sensor.working_range import WorkingRange

PAPER = "Fankhauser et al. 2015"
# [count] of a white frontal surface at 1 m: guess; only ratios to the thresholds below matter
IR_AT_1M = 8000.0
# bright surfaces (reflectance 0.8) are lost below 0.7 m, dark ones (0.1) below 0.25 m: figure 11
SATURATED = 0.8 * IR_AT_1M / 0.7**2
# A white wall's error at 2 m: some 6 mm in the middle, 30 mm at the corners, where a fifth of the light comes back
DARK_ERROR, DARK_AT = 0.0015, 0.8 * IR_AT_1M
RANGE = WorkingRange(0.25, 8.0, f"{PAPER}, figure 11: dark surfaces from 0.25 m; libfreenect2 #152: to about 8 m")
SUN_LUX = 90_000.0

# what holds for every unit in kind, but in size only for the paper's own
_OWN = {
    ("cyclic_error", "amplitude"): 0.005,
    ("amplitude_error", "coefficient"): DARK_ERROR,
}


def kinect_v2_indoors() -> Sensor:
    """1.5 - 0.5 z + 0.3 z^2 + 0.1 z^1.5 theta^2 / (pi/2 - theta)^2 [mm]."""
    axial = AxialNoise(c0=0.0015, c1=-0.0005, c2=0.0003, angle=0.0001, angle_exponent=1.5)
    return _kinect_v2("indoors", (axial, LateralNoise(sigma=0.0016)), "equations (1) and (2), edges without shadow")


def kinect_v2_overcast() -> Sensor:
    """2.5 - 0.7 z + 0.9 z^2 + 0.5 z^1.5 theta^2 / (pi/2 - theta)^2 [mm], 1-12 klx."""
    axial = AxialNoise(c0=0.0025, c1=-0.0007, c2=0.0009, angle=0.0005, angle_exponent=1.5)
    return _kinect_v2("overcast", (axial, LateralNoise(sigma=0.0068)), "equations (4) and (5)")


def kinect_v2_sunlight() -> Sensor:
    """28 - 38 z + 2 z^2 + 0.3 z^1.5 ... + 42 z^2 cos(alpha) [mm], 85-95 klx, the sun behind the camera."""
    axial = AxialNoise(c0=0.028, c1=-0.038, c2=0.002, angle=0.0003, angle_exponent=1.5, sunlight=0.042)
    sun = AmbientLight(ambient=SUN_LUX, noise_share=0.0)  # the noise law was measured in the sun
    sensor = _kinect_v2("sunlight", (axial, sun), "equation (6)")
    source = f"{PAPER}, table II: 73 % valid at 1 m and 45 deg, none at 2.8 m"
    return replace(sensor, sources={**sensor.sources, "ambient_light": source})


def _kinect_v2(light: str, noise: tuple[Effect, ...], equations: str) -> Sensor:
    common = (
        IlluminationVignetting(exponent=2.0, ir_at_1m=IR_AT_1M),
        MixedPixels(fill=1.0),
        CyclicError(amplitude=0.005, period=0.9375, phase=0.0),
        AmplitudeError(coefficient=DARK_ERROR, exponent=1.0, ir_reference=DARK_AT),
        Saturation(ir_threshold=SATURATED),
        AmplitudeDropout(ir_threshold=40.0, width=8.0),
        DepthQuantization(step=0.001),
    )
    sources = {
        "illumination_vignetting": "profile and counts: guess; figure 5 shows the dark borders",
        "mixed_pixels": "from memory: a lens array collects over nearly the whole pixel",
        "cyclic_error": f"{PAPER}, figure 4: within 6 mm from 0.7 to 2.75 m; period guess: c / 2f of 80 MHz over 2",
        "amplitude_error": f"{PAPER}, figure 5: 6 mm in the middle to 30 mm at the borders at 2 m",
        "saturation": f"{PAPER}, figure 11: bright surfaces from 0.7 m, dark ones from 0.25 m",
        "amplitude_dropout": "guess; far below every pixel of the paper's tables",
        "depth_quantization": "files hold millimetres",
    }
    sources |= {effect.name: f"{PAPER}, {equations}" for effect in noise}
    name, effects = f"kinect-v2-{light}", (*common, *noise)
    return Sensor(
        name, Principle.TIME_OF_FLIGHT, effects, sensor="Kinect v2", works=RANGE, std=dict(_OWN), sources=sources
    )
