"""Two walls that meet: light that goes by the other wall."""

import numpy as np

from fusion.simulation.scene.course import looking_at, standing
from fusion.simulation.scene.scene import Scene, StatedPoses
from fusion.simulation.scenes.panel import SURVEY_M, SURVEY_RAD, WARM_S, panel

BLACK = 0.03  # black velvet or foil


def corner(
    distance_m: float = 1.5,
    angle_deg: float = 90.0,
    reflectance: float = 0.8,
    black: bool = False,
    frames: int = 10,
) -> Scene:
    """two walls that meet in a vertical line, seen along their bisector; black=yes darkens the second"""
    half = np.deg2rad(angle_deg) / 2
    ends = 3.0 * np.array([[np.cos(half), np.sin(half)], [np.cos(half), -np.sin(half)]])
    walls = []
    for (x, y), value in zip(ends, (reflectance, BLACK if black else reflectance), strict=True):
        corners = [(x, y, -1.5), (0, 0, -1.5), (0, 0, 1.5), (x, y, 1.5)]
        walls.append(panel(corners if y > 0 else corners[::-1], value))
    return Scene(
        name="corner",
        parts=tuple(walls),
        course=standing([looking_at(np.array([distance_m, 0.0, 0.0]), np.zeros(3))], frames, start_s=WARM_S),
        poses=StatedPoses("surveyed", SURVEY_M, SURVEY_RAD),
        ambient_lux=300.0,
    )
