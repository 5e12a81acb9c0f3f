"""The open turntable challenges' true depth errors as a sensor model, which undoes them.

truth.json names them by its simulator's own words. Which law of ours each one is was worked out on the walls of the
cases (true camera, planes fitted, laser distances):

- v1: `disparity_offset_px` and `radial_px_per_r2` (r: tangent of the ray's angle) are added to the disparity, then the
  depth is scaled. Wall distances agree within 1 mm up to 1.4 m, residuals over the radius within 0.3 mm.
- v2: `depth_offset_m` and `radial_m_per_r2` are added to the range. `cyclic_relative` is the share of a second and
  fourth harmonic of the correlation: with three phase steps they turn three and six times per turn of the phase, at 80
  and 120 MHz (16 MHz leaves nothing). Heights and phases of these four waves are fitted to the walls, with the rest
  held at the truth: residuals of 0.55 mm rms over nine walls, where one wave leaves 1.8 mm.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from fusion.geometry.camera import Camera
from fusion.sensor.effect import Effect
from fusion.sensor.effects.phase.cyclic_error import CyclicError
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.effects.readout.depth_scale import DepthScale
from fusion.sensor.effects.readout.fixed_pattern import FixedPattern
from fusion.sensor.effects.triangulation.disparity_distortion import DisparityDistortion
from fusion.sensor.effects.triangulation.disparity_offset import DisparityOffset
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import LIGHT_SPEED, stretch

# of each unit: frequency [Hz], waves per turn of the phase, height [m], phase [rad]
WAVES = {
    "turntable_v2_bricks": (
        (80e6, 3, 3.98e-3, 2.47), (120e6, 3, 2.72e-3, 1.91), (120e6, 6, 1.77e-3, 1.81), (80e6, 6, 1.39e-3, 2.97),
    ),
    "turntable_v2_statue": (
        (80e6, 3, 4.16e-3, 3.69), (120e6, 3, 4.21e-3, 2.20), (120e6, 6, 1.71e-3, 3.13), (80e6, 6, 1.26e-3, 3.87),
    ),
}  # fmt: skip


def true_sensor(noise: Sensor, truth: dict[str, Any], stated: Camera, true: Camera) -> Sensor:
    """The case's noise model with its true depth errors, to be used with the true camera.

    Args:
        truth: content of truth.json.
        stated, true: camera of the recording, and the one that took it.
    """
    errors = truth["depth_bias"]
    x, y = np.moveaxis(true.rays().astype(float), -1, 0)
    r2 = x**2 + y**2
    effects: tuple[Effect, ...]
    if "disparity_offset_px" in errors:
        effects = (
            DisparityOffset(offset=errors["disparity_offset_px"]),
            DisparityDistortion(map=errors["radial_px_per_r2"] * r2),
            DepthScale(scale=errors["depth_scale"]),
        )
    else:
        frequency, turns, height, phase = np.array(WAVES[truth["id"]]).T
        effects = (
            CyclicError(amplitude=height, period=LIGHT_SPEED / (2 * frequency) / turns, phase=phase),
            DepthOffset(offset=errors["depth_offset_m"]),
            FixedPattern(map=errors["radial_m_per_r2"] * r2),
            # the files hold the range as a depth along the stated rays
            DepthScale(scale=stretch(true).astype(float) / stretch(stated) - 1),
        )
    for effect in effects:
        noise = noise.having(effect)
    return replace(noise, name=f"{noise.name}, true errors")
