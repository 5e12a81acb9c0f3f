"""Blocks at made-up walls, without files: tilted planes with patches, seen by a sensor with something to hide."""

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from fusion.discrepancy.inference.scatter import Loose, loose_of
from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.naming.search.candidates import candidates_of
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.observations import observe
from fusion.discrepancy.unknown.unrestricted import groups_of
from fusion.geometry.camera import Camera
from fusion.sensor.effect import Effect
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.moment import Moment
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Edges, View, incidence_of

WIDTH, HEIGHT, FRAMES = 112, 80, 6
KNOWN = {
    "itof": AxialNoise(c0=0.002),
    "structured_light": AxialNoise(sigma_px=0.03),
}
# distance [m], turn about the vertical and the horizontal [deg]
WALLS = [
    (0.8, 0, 0),
    (1.1, 35, 0),
    (1.4, -30, 15),
    (1.8, 10, -25),
    (2.3, 40, 5),
    (2.8, -15, 10),
    (1.0, 5, 30),
    (2.0, -40, -10),
]


def sensor_of(principle: str, *hidden: Effect) -> Sensor:
    """The known sensor, with effects added."""
    return Sensor("made up", principle, (*hidden, KNOWN[principle]))


def looks_at(
    sensor: Sensor, seed: int, walls: Sequence[tuple[float, float, float]] = WALLS, off: float = 1.0
) -> list[FrameBlock]:
    """What the sensor gives of the walls, one recording each."""
    return [look_at(sensor, place, wall, seed, off) for place, wall in enumerate(walls)]


def look_at(
    sensor: Sensor,
    place: int,
    wall: tuple[float, float, float],
    seed: int,
    off: float = 1.0,
    placement: int | None = None,
) -> FrameBlock:
    """One wall; its stated pose is off by `off` times a millimetre and a milliradian, as stated."""
    rng = np.random.default_rng([seed, place])
    stated = view_of(sensor.principle, wall, place)
    shift = off * rng.normal(0, [0.001, 0.06, 0.06])  # [m], [deg]
    true = view_of(sensor.principle, tuple(np.add(wall, shift)), place)
    true = replace(true, moment=replace(true.moment, placement=placement))
    assert true.depth is not None
    frames = np.array([sensor.sample(true.depth, true, None, rng) for _ in range(FRAMES)])
    stage = SimpleNamespace(place=place, sigma_m=0.001 * off, sigma_rad=0.001 * off, mesh_sigma_m=0.0, caster=None)
    count = np.isfinite(frames).sum(axis=0).astype(np.int32)
    return FrameBlock(stage, tuple(range(FRAMES)), stated, frames.mean(axis=0), frames.std(axis=0, ddof=1), count)


def loose_in(blocks: Sequence[FrameBlock]) -> Loose:
    """What follows no law, as the engine tells it."""
    observations = observe(sensor_of("itof"), blocks)
    covariance = covariance_of(observations)
    return loose_of(
        observations, covariance, candidates_of(observations, covariance), groups_of(observations, covariance)
    )


def view_of(principle: str, wall: tuple[float, ...], place: int) -> View:
    """A plane through the optical axis at a distance, with patches of three reflectances."""
    camera = Camera(WIDTH, HEIGHT, 98.0, 98.0, 55.5, 39.5, principle=principle)
    a, b = np.deg2rad(wall[1]), np.deg2rad(wall[2])
    n = np.array([np.sin(a) * np.cos(b), np.sin(b), -np.cos(a) * np.cos(b)])
    rays = np.dstack([camera.rays(), np.ones(camera.shape)]).astype(float)
    depth = n[2] * wall[0] / (rays @ n)
    normals = np.broadcast_to(n, rays.shape).copy()
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    reflectance = np.array([0.8, 0.3, 0.5])[(u // 32 + v // 32 + place) % 3]
    nowhere = np.zeros(camera.shape)
    edges = Edges(np.full(camera.shape, np.inf), nowhere, nowhere, nowhere + 1)
    incidence = incidence_of(normals, camera)
    ir = 3000.0 * reflectance * np.cos(incidence) / (depth**2 * (rays**2).sum(axis=-1))
    moment = Moment(time=300.0 * place, temperature=25.0 + 8.0 * (1 - np.exp(-0.5 * place)), ambient=300.0)
    view = View(camera, depth, incidence, normals, ir=ir, reflectance=reflectance, edges=edges)
    return replace(view, moment=moment, principle=principle)
