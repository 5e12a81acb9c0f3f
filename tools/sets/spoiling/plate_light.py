"""Light that goes from a time-of-flight camera to the plate, from there to the object, and back: summed over the plate.

Both scatter evenly in all directions (Lambert). Where the camera does not see the plate, its light does not shine.
"""

import numpy as np

from tools.sets.planted.shapes import Array
from tools.sets.planted.stage import OBJECT, Hits, Stage

ALBEDO = 0.6  # of the plate: light wood
FREQUENCY, C = 80e6, 299_792_458.0  # [Hz], [m/s]
RINGS, ROUND = 14, 36
AT_ONCE = 2000  # pixels


def added(stage: Stage, hits: Hits) -> Array:
    """(h, w) what the light by way of the plate adds to the range [m], 0 off the object."""
    rays, T = stage.camera.rays, stage.T_world_camera
    world = (rays * np.where(np.isfinite(hits.z), hits.z, 0)[..., None]) @ T[:3, :3].T + T[:3, 3]
    normals = np.cross(np.gradient(world, axis=0), np.gradient(world, axis=1))
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
    normals *= np.sign(np.sum(normals * (T[:3, 3] - world), axis=-1, keepdims=True))
    places, areas = _plate(stage, hits)
    out = np.zeros(hits.z.shape)
    rows = np.argwhere(hits.part == OBJECT)
    for at in np.array_split(rows, max(1, len(rows) // AT_ONCE)):
        v, u = at.T
        out[v, u] = _over(world[v, u], normals[v, u], T[:3, 3], places, areas)
    return out


def _plate(stage: Stage, hits: Hits) -> tuple[Array, Array]:
    """Places (m, 3) of the plate that the camera shines on, and their areas [m^2]."""
    radius = float(np.linalg.norm(stage.plate.mesh.vertices[:, :2], axis=1).max())
    r = (np.arange(RINGS) + 0.5) / RINGS * radius
    a = np.arange(ROUND) / ROUND * 2 * np.pi
    places = np.stack([np.outer(r, np.cos(a)), np.outer(r, np.sin(a)), np.zeros((RINGS, ROUND))], axis=-1).reshape(
        -1, 3
    )
    areas = np.repeat(2 * np.pi * r * radius / RINGS / ROUND, ROUND)
    T, camera = np.linalg.inv(stage.T_world_camera), stage.camera
    local = places @ T[:3, :3].T + T[:3, 3]
    u, v = np.rint(local[:, :2] / local[:, 2:] * camera.f + [camera.cx, camera.cy]).astype(int).T
    inside = (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
    shown = hits.z[v.clip(0, camera.height - 1), u.clip(0, camera.width - 1)] > local[:, 2] - 0.01
    return places[inside & shown], areas[inside & shown]


def _over(points: Array, normals: Array, centre: Array, places: Array, areas: Array) -> Array:
    """(n,) [m]"""
    way = places[None] - points[:, None]  # (n, m, 3)
    between = np.linalg.norm(way, axis=2)
    direct, lit = np.linalg.norm(centre - points, axis=1), np.linalg.norm(centre - places, axis=1)
    facing = np.maximum(np.einsum("nmk,nk->nm", way, normals) / between, 0)
    leaving = np.maximum(-way[..., 2] / between, 0)
    onto = np.maximum((centre - places)[:, 2] / lit, 0)
    straight = np.maximum(np.sum((centre - points) * normals, axis=1) / direct, 0.05) / direct**2
    near = np.maximum(between, 0.004)  # a cell of the plate is no point
    share = ALBEDO / np.pi * (onto / lit**2 * areas) * facing * leaving / near**2 / straight[:, None]
    extra = (lit[None] + between - direct[:, None]) / 2
    wave = 1 + np.sum(share * np.exp(4j * np.pi * FREQUENCY * extra / C), axis=1)
    return np.asarray(np.angle(wave) * C / (4 * np.pi * FREQUENCY))
