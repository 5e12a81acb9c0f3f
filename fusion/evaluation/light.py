"""The ambient light at the targets, from their noise."""

from collections.abc import Sequence

import numpy as np

from fusion.calibration.noise.ambient import AmbientEstimate, LightPoint, estimate_ambient
from fusion.calibration.noise.target_noise import TargetNoise
from fusion.geometry.camera import Camera
from fusion.sensor.sensor import Sensor


def ambient_light(
    noises: Sequence[TargetNoise], camera: Camera, sensor: Sensor | None = None
) -> AmbientEstimate | None:
    """Ambient light with its interval; None where no law of this sensor's noise over light is known."""
    return estimate_ambient([_point(noise) for noise in noises], camera, sensor)


def _point(noise: TargetNoise) -> LightPoint:
    """The noise of a target with its rounding taken out: steps add a twelfth of their square."""
    variance = noise.axial**2 - noise.step**2 / 12
    sigma = float(np.sqrt(variance)) if variance > 0 else float("nan")
    # the deviation of a variance stays, that of its smaller root grows
    deviation = noise.axial_std * noise.axial / sigma if sigma > 0 else float("nan")
    return LightPoint(noise.depth, noise.tilt, sigma, deviation, noise.valid)
