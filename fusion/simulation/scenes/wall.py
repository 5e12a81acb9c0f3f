"""A large flat wall, from several distances and angles."""

import numpy as np

from fusion.simulation.scene.course import standing
from fusion.simulation.scene.scene import Scene, StatedPoses
from fusion.simulation.scenes.panel import SURVEY_M, SURVEY_RAD, WARM_S, before, upright


def wall(
    distance_m: tuple[float, ...] = (1.0,),
    tilt_deg: tuple[float, ...] = (0.0,),
    reflectance: float = 0.8,
    frames: int = 10,
    ambient_lux: float = 300.0,
    sigma_m: float = SURVEY_M,
    sigma_rad: float = SURVEY_RAD,
) -> Scene:
    """a flat wall; each distance (along the optical axis) at each tilt for some frames"""
    placements = [(d, t) for t in tilt_deg for d in distance_m]
    course = standing([before(d, t) for d, t in placements], frames, start_s=WARM_S)
    return Scene(
        name="wall",
        parts=(upright((-20.0, 20.0), (-10.0, 10.0), 0.0, reflectance),),
        course=course,
        poses=StatedPoses("surveyed", sigma_m, sigma_rad),
        ambient_lux=ambient_lux,
        telemetry={"distance_m": np.repeat([float(d) for d, _ in placements], frames)},
    )
