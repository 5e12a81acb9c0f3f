"""Light by way of a second surface: points drawn on all surfaces send on what the lamp sends them."""

from dataclasses import dataclass

import cv2
import numpy as np

from tools.trial.furnished.physics.bench import Bench, Key
from tools.trial.furnished.physics.poses import Array
from tools.trial.furnished.physics.sensor import C
from tools.trial.furnished.physics.world import SeenPixels

POINTS = 420


@dataclass(frozen=True)
class Lights:
    """Attributes:
    place, normal: (n, 3) [m] in the world.
    way: (n,) [m] from the lamp.
    power: (n,) light over that of white at 1 m on the axis.
    area: [m^2] that each stands for.
    """

    place: Array
    normal: Array
    way: Array
    power: Array
    area: float


def bounced(bench: Bench, T: Array, hits: SeenPixels, share: float, key: Key) -> tuple[Array, Array]:
    """(frequencies, h, w) and (h, w) [counts] the light's phasors and level."""
    kept = ("bounces", key)
    if key is not None and kept in bench.casts:
        return bench.casts[kept]
    T = T if T.ndim == 2 else T[len(T) // 2]
    sensor, lights = bench.sensor, _lights(bench, T)
    seen = (hits.direction * np.nan_to_num(hits.z, nan=50)[..., None]) @ T[:3, :3].T + T[:3, 3]
    normal = hits.normal @ T[:3, :3].T
    light = np.zeros((len(sensor.frequencies), *seen.shape[:2]), complex)
    level = np.zeros(seen.shape[:2])
    for i in np.flatnonzero(lights.power > 1e-4).tolist():
        open_to = _open_to(bench, lights, i, seen, normal)
        if open_to is None:
            continue
        gap = lights.place[i] - seen
        square = (gap**2).sum(-1)
        way = np.sqrt(square)
        in_cosine = np.clip((gap * normal).sum(-1), 0, None) / way
        out_cosine = np.clip(-(gap @ lights.normal[i]), 0, None) / way
        # the area in the denominator keeps a corner, where the distance goes to 0, from becoming a lamp
        sent = sensor.counts * hits.reflectance * lights.power[i] * in_cosine * out_cosine * lights.area
        amplitude = sent / (np.pi * square + lights.area) * open_to * share
        path = (lights.way[i] + way + np.nan_to_num(hits.range, nan=50)) / 2
        for k, f in enumerate(sensor.frequencies):
            light[k] += amplitude * np.exp(4j * np.pi * f * path / C)
        level += amplitude
    bench.casts[kept] = (light, level)
    return light, level


def _lights(bench: Bench, T: Array) -> Lights:
    world, rng = bench.world, np.random.default_rng(bench.seed + 5)
    corners = world.mesh.vertices.astype(float)[world.mesh.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normal, axis=1) / 2
    face = rng.choice(len(area), POINTS, p=area / area.sum())
    ab = rng.random((POINTS, 2))
    folded = ab.sum(1) > 1
    ab[folded] = 1 - ab[folded]
    first = corners[face, 0]
    place = first + ab[:, :1] * (corners[face, 1] - first) + ab[:, 1:] * (corners[face, 2] - first)
    normal = normal[face] / (2 * area[face])[:, None]
    origin = T[:3, 3]
    back = origin - place
    way = np.linalg.norm(back, axis=1)
    back /= way[:, None]
    normal *= np.sign((normal * back).sum(1))[:, None]
    lit = ~world.blocked(place + 0.003 * normal, np.broadcast_to(origin, place.shape)) & (way > 0.2)
    cosine = (normal * back).sum(1)
    axis = np.clip(-(back @ T[:3, 2]), 0, 1)  # cosine of the angle from the optical axis
    power = np.where(lit, world.mesh.reflectance[face] * cosine / way**2 * axis**bench.sensor.falloff, 0)
    return Lights(place, normal, way, power, area.sum() / POINTS)


def _open_to(bench: Bench, lights: Lights, i: int, seen: Array, normal: Array) -> Array | None:
    """(h, w) whether pixels see a light, by every some pixels and smooth between; None where none does."""
    stride = max(1, seen.shape[1] // 40)
    some, away = seen[::stride, ::stride], normal[::stride, ::stride]
    target = np.broadcast_to(lights.place[i] + 0.004 * lights.normal[i], some.shape)
    free = ~bench.world.blocked(some + 0.004 * away, target)
    if not free.any():
        return None
    size = (seen.shape[1], seen.shape[0])
    return cv2.resize(free.astype(np.float32), size, interpolation=cv2.INTER_LINEAR)
