"""What the pictures of the effect pages look at: one pixel at a time, or a small image."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fusion.geometry.camera import Camera, Principle
from fusion.sensor.moment import Moment
from fusion.sensor.view import Edges, Image, View, incidence_of

FX = 580.0  # [px] with the baseline of a Kinect v1: 43.5 px m
NEAR, FAR = 1.5, 2.0  # [m] on both sides of the edges in the pictures
WIDTH, HEIGHT = 640, 480
CARD = (170.0, 132.0, 330.0, 348.0)  # left, top, right and bottom of a card in the image [px]
# the table in the pictures: 1 m before the camera, which looks down on it by 30 deg
AXIS_POINT = np.array([0.0, 0.1, 1.0])
AXIS = np.array([0.0, -np.cos(np.pi / 6), -np.sin(np.pi / 6)])


@dataclass(frozen=True)
class Seen:
    """What one pixel looks at: slope of its ray (x, y), tilt of the wall about the image's y axis [rad]."""

    depth: float = 2.0
    x: float = 0.0
    y: float = 0.0
    tilt: float = 0.0


FLIGHT = Principle.TIME_OF_FLIGHT


def pixel(seen: Seen, principle: Principle = Principle.STRUCTURED_LIGHT, **more: Any) -> View:
    """A view of one pixel with normals and incidence; `more` are fields of `View`."""
    camera = Camera(1, 1, FX, FX, -seen.x * FX, -seen.y * FX, principle=principle)
    normal = np.array([[[np.sin(seen.tilt), 0.0, -np.cos(seen.tilt)]]])
    depth = np.full((1, 1), seen.depth)
    return View(camera, depth, incidence_of(normal, camera), normal, **more)


def at(depth: float, principle: Principle = Principle.STRUCTURED_LIGHT, **more: Any) -> View:
    """The middle pixel before a frontal wall."""
    return pixel(Seen(depth), principle, **more)


def one(value: float) -> Image:
    """An image of one pixel."""
    return np.full((1, 1), value)


def beside_edge(position: float, principle: Principle = Principle.STRUCTURED_LIGHT, **more: Any) -> View:
    """A pixel at a place across an edge [px]: negative on the near side (1.5 m), positive on the far side (2 m)."""
    near = position < 0
    jump, light = (FAR - NEAR, (NEAR / FAR) ** 2) if near else (NEAR - FAR, (FAR / NEAR) ** 2)
    edges = Edges(one(abs(position)), one(0.0 if near else np.pi), one(jump), one(light))
    return at(NEAR if near else FAR, principle, edges=edges, **more)


def on_table(place: tuple[float, float, float], normal: tuple[float, float, float], angle: float) -> View:
    """A pixel that sees a point near the turntable.

    Args:
        place: along the plate towards the camera, along the plate to its side, above the plate [m].
        normal: of the surface there, in the same directions.
        angle: of the table [rad].
    """
    to_camera = -AXIS_POINT - (-AXIS_POINT @ AXIS) * AXIS
    first = to_camera / np.linalg.norm(to_camera)
    frame = np.array([first, np.cross(AXIS, first), AXIS])
    P, n = AXIS_POINT + np.array(place) @ frame, np.array(normal) @ frame
    view = pixel(Seen(P[2], P[0] / P[2], P[1] / P[2]))
    n = (n / np.linalg.norm(n)).reshape(1, 1, 3)
    moment = Moment(table_angle=angle, axis_point=AXIS_POINT, axis_direction=AXIS)
    return replace(view, normals=n, incidence=incidence_of(n, view.camera), moment=moment)


def wall(depth: float = 2.0, tilt: float = 0.0, principle: Principle = Principle.STRUCTURED_LIGHT) -> View:
    """An image of a wall, for unit 3 and placement 5 of what is frozen."""
    camera = Camera(WIDTH, HEIGHT, FX, FX, (WIDTH - 1) / 2, (HEIGHT - 1) / 2, principle=principle)
    rays = np.dstack([camera.rays().astype(float), np.ones(camera.shape)])
    n = np.array([np.sin(tilt), 0.0, -np.cos(tilt)])
    normals = np.broadcast_to(n, rays.shape).copy()
    return View(
        camera, n[2] * depth / (rays @ n), incidence_of(normals, camera), normals, moment=Moment(unit=3, placement=5)
    )


def card_before_wall(near: float, far: float, principle: Principle) -> View:
    """A bright card before a darker wall, with the amplitude that comes back."""
    view = wall(far, principle=principle)
    left, top, right, bottom = CARD
    card = (view.u > left) & (view.u < right) & (view.v > top) & (view.v < bottom)
    z = np.where(card, near, far)
    ir = 1000.0 * np.where(card, 0.8, 0.3) / (z * view.stretch) ** 2
    return replace(view, depth=z, ir=ir)
