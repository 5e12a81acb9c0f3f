"""The ambient light, estimated from the noise of targets: the opening that Fankhauser left."""

from collections.abc import Sequence

from fusion.calibration.noise.target_noise import TargetNoise
from fusion.geometry.camera import Camera
from fusion.sensor.sensor import Sensor

AmbientLight = dict[str, object]


def ambient_light(noises: Sequence[TargetNoise], camera: Camera, sensor: Sensor | None) -> AmbientLight | None:
    """Ambient light with its interval; None where the noise says nothing of it."""
    return None
