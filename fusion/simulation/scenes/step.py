"""A step: one straight depth edge, a little slanted against the pixels."""

import numpy as np

from fusion.simulation.scene.course import standing
from fusion.simulation.scene.scene import Scene, StatedPoses
from fusion.simulation.scenes.panel import SURVEY_M, SURVEY_RAD, WARM_S, before, panel, upright


def step(
    distance_m: float = 1.0,
    step_m: float = 0.3,
    slant_deg: float = 5.0,
    near_reflectance: float = 0.8,
    far_reflectance: float = 0.8,
    frames: int = 10,
) -> Scene:
    """a near plate before a wall, its edge slanted: edge blur, mixed pixels, shadow"""
    lean = np.tan(np.deg2rad(slant_deg))
    # the plate covers the camera's left half: +y of the world is to its right
    near = panel([(step_m, -4, -3), (step_m, -3 * lean, -3), (step_m, 3 * lean, 3), (step_m, -4, 3)], near_reflectance)
    return Scene(
        name="step",
        parts=(near, upright((-20.0, 20.0), (-10.0, 10.0), 0.0, far_reflectance)),
        course=standing([before(distance_m + step_m)], frames, start_s=WARM_S),
        poses=StatedPoses("surveyed", SURVEY_M, SURVEY_RAD),
        ambient_lux=300.0,
    )
