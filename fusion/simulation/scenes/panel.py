"""Flat things to build scenes from: one rectangle, one reflectance."""

import numpy as np
from numpy.typing import ArrayLike

from fusion.errors import SceneError
from fusion.geometry.pose import Array
from fusion.mesh.mesh import Mesh
from fusion.simulation.scene.course import looking_at
from fusion.simulation.scene.scene import Part

SURVEY_M, SURVEY_RAD = 0.0005, 0.0005  # guess: a good total station and a careful mount
WARM_S = 3600.0  # [s] since switch-on: a depth camera is warm after 40 to 50 minutes


def panel(corners: ArrayLike, reflectance: float) -> Part:
    """A flat quadrangle (4, 3) [m], corners counter-clockwise seen from its front, in one grey."""
    grey = np.full((4, 3), round(255 * min(max(reflectance, 0.0), 1.0)), np.uint8)
    mesh = Mesh(np.asarray(corners, float), np.array([[0, 1, 2], [0, 2, 3]], np.int32), colors=grey)
    return Part(mesh, reflectance)


def upright(y: tuple[float, float], z: tuple[float, float], x: float, reflectance: float) -> Part:
    """A rectangle in the plane of one x [m] that faces +x."""
    return panel([(x, y[0], z[0]), (x, y[1], z[0]), (x, y[1], z[1]), (x, y[0], z[1])], reflectance)


def before(distance: float, tilt_deg: float = 0.0) -> Array:
    """The pose (4, 4) of a camera before the plane x = 0: its axis meets the origin after `distance` [m]."""
    if not (np.isfinite(distance) and 0 < distance <= 1000):
        raise SceneError("the distance cannot be used", found=distance, expected="above 0 m")
    if not abs(tilt_deg) < 90:
        raise SceneError("the tilt cannot be used", found=tilt_deg, expected="less than 90 degrees")
    tilt = np.deg2rad(tilt_deg)
    return looking_at(distance * np.array([np.cos(tilt), np.sin(tilt), 0.0]), np.zeros(3))
