"""A flat target that stands free in a room, from several distances and angles."""

import numpy as np

from fusion.simulation.scene.course import standing
from fusion.simulation.scene.scene import Scene, StatedPoses
from fusion.simulation.scenes.panel import SURVEY_M, SURVEY_RAD, WARM_S, before, panel, upright

ROLL = np.deg2rad(3.0)  # nobody puts a target exactly upright, and an edge along a column says little


def target(
    distance_m: tuple[float, ...] = (1.0,),
    tilt_deg: tuple[float, ...] = (0.0,),
    width_m: float = 0.42,
    height_m: float = 0.42,
    reflectance: float = 0.8,
    behind_m: float = 1.0,
    frames: int = 10,
    ambient_lux: float = 300.0,
) -> Scene:
    """a flat target that stands free; each distance (along the axis) at each tilt for some frames"""
    placements = [(d, t) for t in tilt_deg for d in distance_m]
    y, z = 0.5 * width_m, 0.5 * height_m
    turn = np.array([[np.cos(ROLL), -np.sin(ROLL)], [np.sin(ROLL), np.cos(ROLL)]])
    corners = [(0.0, *(turn @ corner)) for corner in ((-y, -z), (y, -z), (y, z), (-y, z))]
    # a turned camera looks past the target along the first wall: a second one, far to the side, ends its view
    side = -behind_m - 1.0
    parts = (
        panel(corners, reflectance),
        upright((-20.0, 20.0), (-10.0, 10.0), -behind_m, reflectance),
        panel([(20.0, side, -10.0), (-20.0, side, -10.0), (-20.0, side, 10.0), (20.0, side, 10.0)], reflectance),
    )
    course = standing([before(d, t) for d, t in placements], frames, start_s=WARM_S)
    return Scene(
        name="target",
        parts=parts,
        course=course,
        poses=StatedPoses("surveyed", SURVEY_M, SURVEY_RAD),
        ambient_lux=ambient_lux,
        telemetry={"distance_m": np.repeat([float(d) for d, _ in placements], frames)},
    )
