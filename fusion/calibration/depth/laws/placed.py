"""Where walls of unknown distance stand: where the law says, and not where the depth did that the law corrects."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fusion.calibration.depth.walls.plane import plane_through
from fusion.calibration.depth.walls.wall import Wall
from fusion.geometry.camera import Camera
from fusion.sensor.sensor import Sensor


def placed(walls: Sequence[Wall], sensor: Sensor, camera: Camera) -> list[Wall]:
    """The walls, those of unknown distance at the plane through what the sensor model makes of their depth.

    Terms of a law are those of the true depth: a wave that is read 15 mm beside it has a second one of half its period.
    """
    found = []
    for wall in walls:
        if not np.isfinite(wall.distance):
            depth = sensor.correct(wall.measured, wall.view(camera, wall.measured))
            seen = wall.mask & np.isfinite(depth)
            wall = replace(wall, placed=plane_through(depth, seen, camera)) if seen.sum() > 3 else wall
        found.append(wall)
    return found
