"""A scene that stands still while the sensor warms up."""

import numpy as np

from fusion.simulation.scene.course import stamps, standing
from fusion.simulation.scene.scene import Scene, StatedPoses
from fusion.simulation.scenes.panel import SURVEY_M, SURVEY_RAD, before, upright

ROOM_C, RISE_C, RISE_S = 23.0, 9.0, 900.0  # guess: a closed camera of 5 to 15 W


def warm_up(
    distance_m: float = 1.2, frames: int = 20, minutes: float = 50.0, start_s: float = 60.0, reflectance: float = 0.7
) -> Scene:
    """a plate before a wall, few frames over a long time from switch-on, with the temperature"""
    frame_s = 60.0 * minutes / max(frames - 1, 1)
    times = stamps(frames, frame_s, start_s)
    warming = np.exp(-times / RISE_S)
    near = upright((-0.35, 0.05), (-0.25, 0.2), 0.35, reflectance)
    return Scene(
        name="warm-up",
        parts=(upright((-20.0, 20.0), (-10.0, 10.0), 0.0, reflectance), near),
        course=standing([before(distance_m)], frames, frame_s, start_s),
        poses=StatedPoses("surveyed", SURVEY_M, SURVEY_RAD),
        ambient_lux=300.0,
        telemetry={"temperature_c": ROOM_C + RISE_C * (1 - warming)},
    )
