"""A made-up view in which every sensor effect has something to act on, and one clearly visible value of each."""

from dataclasses import replace

import numpy as np

from fusion.geometry.camera import Camera
from fusion.sensor.effect import Effect
from fusion.sensor.moment import Moment
from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Edges, Indirect, View, incidence_of

WIDTH, HEIGHT = 64, 48
CAMERA = Camera(WIDTH, HEIGHT, 57.0, 57.0, 31.2, 23.9, principle="structured_light")
# where a near square ends, between the pixels [px]
LEFT, RIGHT, TOP, BOTTOM = 19.7, 35.4, 14.6, 30.3
BASELINE = 0.75  # [m] times the 57 px: the 43 px m of a Kinect v1
STEP = 0.3  # [m] that it stands before the wall


def rich_view(kind: type[Effect] | None = None, placement: int = 5) -> View:
    """A turned wall of 0.8 to 3.5 m with patches of reflectance, a near square, a hole; moving and warming up.

    The principle is one that the effect can have.
    """
    of_light = kind is not None and (kind.__module__.split(".")[-2] in ("light", "phase"))
    principle = (kind.principles if kind else ()) or (("itof",) if of_light else ("structured_light",))
    camera = replace(CAMERA, principle=principle[0])
    u, v = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    rays = np.dstack([camera.rays(), np.ones((HEIGHT, WIDTH))])
    # a wall through (0, 0, 1.3) turned by 40 deg about y and 15 about x; the square is the same, nearer
    n = np.array([0.62, -0.2, -0.76]) / np.linalg.norm([0.62, -0.2, -0.76])
    wall = n[2] * 1.3 / (rays @ n)
    near = (u > LEFT) & (u < RIGHT) & (v > TOP) & (v < BOTTOM)
    depth = np.where(near, wall - STEP, wall)
    normals = np.broadcast_to(n, rays.shape).copy()
    depth[:4, :4] = np.nan
    normals[:4, :4] = np.nan
    reflectance = np.where((u // 8 + v // 6) % 2 == 0, 0.25, 0.8)
    indirect = Indirect(0.1 * np.exp(-u / 20.0), np.full(u.shape, 0.15) + 0.002 * v)
    moment = Moment(
        time=900.003,  # between two zeros of the mains' light
        temperature=33.0,
        ambient=5000.0,
        table_angle=2.0,
        axis_point=np.array([0.05, 0.1, 1.3]),
        axis_direction=np.array([0.0, -0.9, -np.sqrt(1 - 0.81)]),
        previous=depth + 0.01,
        unit=3,
        placement=placement,
    )
    view = View(
        camera,
        depth,
        incidence_of(normals, camera),
        normals,
        reflectance=reflectance,
        edges=_edges(u, v, near),
        lit=np.where((u > 36) & (u < 41) & (v > TOP) & (v < BOTTOM), 0.0, 1.0),
        indirect=indirect,
        velocity=np.dstack([np.full(u.shape, 0.8), 0.002 * u, np.full(u.shape, 0.1)]),
        turning=u < 50,
        moment=moment,
        baseline=BASELINE,
    )
    distance = np.nan_to_num(depth, nan=1.0)
    return replace(view, ir=1000.0 * reflectance * np.cos(np.nan_to_num(view.incidence)) / distance**2)


def typical(kind: type[Effect]) -> Effect:
    """The effect at its parameters' typical values."""
    return kind(**{p.name: p.typical for p in parameters(kind).values()})


def sensor_of(*effects: Effect) -> Sensor:
    """A sensor with these effects only, whose disparities are those of a Kinect in spite of the few wide pixels."""
    return Sensor(effects=effects, baseline=BASELINE)


def _edges(u: np.ndarray, v: np.ndarray, near: np.ndarray) -> Edges:
    """Distances to the outline of the square, by its four sides and its corners."""
    across_u, across_v = np.clip(u, LEFT, RIGHT), np.clip(v, TOP, BOTTOM)
    sides = np.stack([u - LEFT, RIGHT - u, v - TOP, BOTTOM - v])
    side = np.argmin(sides, axis=0)
    inside = sides.min(axis=0)
    outside = np.hypot(u - across_u, v - across_v)
    distance = np.where(near, inside, outside)
    towards = np.array([np.pi, 0.0, -np.pi / 2, np.pi / 2])[side]
    direction = np.where(near, towards, np.arctan2(across_v - v, across_u - u))
    close = distance < 8
    return Edges(
        np.where(close, distance, np.inf),
        np.where(close, direction, 0.0),
        np.where(close, np.where(near, STEP, -STEP), 0.0),
        np.where(close, 0.7, 1.0),
    )
