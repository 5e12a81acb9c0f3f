"""A bright card close to the camera: light that it scatters in the lens reaches the rest of the picture."""

import numpy as np

from fusion.simulation.scene.course import standing
from fusion.simulation.scene.scene import Scene, StatedPoses
from fusion.simulation.scenes.panel import SURVEY_M, SURVEY_RAD, WARM_S, before, upright


def near_card(
    card: bool = True,
    distance_m: float = 2.0,
    card_distance_m: float = 0.4,
    reflectance: float = 0.3,
    card_reflectance: float = 0.9,
    frames: int = 10,
) -> Scene:
    """a wall, and a bright card near the camera (card=no: the same recording without it)"""
    parts = [upright((-20.0, 20.0), (-10.0, 10.0), 0.0, reflectance)]
    if card:
        x = distance_m - card_distance_m
        # the left fifth of a picture of 60 degrees
        left, right = np.array([-0.9, -0.28]) * card_distance_m
        parts.append(upright((left, right), (-0.3 * card_distance_m, 0.3 * card_distance_m), x, card_reflectance))
    return Scene(
        name="near-card" if card else "near-card, without the card",
        parts=tuple(parts),
        course=standing([before(distance_m)], frames, start_s=WARM_S),
        poses=StatedPoses("surveyed", SURVEY_M, SURVEY_RAD),
        ambient_lux=300.0,
    )
