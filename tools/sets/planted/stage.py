"""The stage: an object on a round plate that turns before a still camera, a table top, a floor and a wall."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from tools.sets.planted.shapes import BRIGHT, PLAIN, WOOD, Array, Paint, Rng, joined, paint

PLATE_HEIGHT = 0.025  # [m] of the plate over the table
TABLE_HEIGHT = 0.75  # [m]
NOTHING, STILL, PLATE, OBJECT = range(4)


@dataclass(frozen=True)
class Pinhole:
    """The true camera; the centre of the top-left pixel is (0, 0)."""

    width: int
    height: int
    f: float
    cx: float
    cy: float

    @cached_property
    def rays(self) -> Array:
        """(h, w, 3) directions with z = 1."""
        u, v = np.meshgrid(np.arange(self.width), np.arange(self.height))
        return np.stack([(u - self.cx) / self.f, (v - self.cy) / self.f, np.ones(u.shape)], axis=-1)


@dataclass(frozen=True)
class Hits:
    """What each pixel (h, w) sees: z [m] (inf where nothing), the part, cosine of incidence, the point in its part."""

    z: Array
    part: NDArray[np.int8]
    cosine: Array
    point: Array


class Solid:
    """A mesh that rays can hit, in a frame of its own."""

    def __init__(self, mesh: trimesh.Trimesh) -> None:
        import open3d as o3d

        self.mesh = mesh
        self.reach = float(np.linalg.norm(mesh.vertices, axis=1).max())
        self._tensor = o3d.core.Tensor.from_numpy
        self._scene: Any = o3d.t.geometry.RaycastingScene()
        self._scene.add_triangles(
            self._tensor(np.asarray(mesh.vertices, np.float32)), self._tensor(np.asarray(mesh.faces, np.uint32))
        )

    def hit(self, T_solid_camera: Array, rays: Array) -> tuple[Array, Array, Array]:
        """Length along each ray (n, 3) in its own units, cosine of incidence, the point hit in the solid's frame."""
        way = rays @ T_solid_camera[:3, :3].T
        start = T_solid_camera[:3, 3]
        both = np.concatenate([np.broadcast_to(start, way.shape), way], axis=1).astype(np.float32)
        answer = self._scene.cast_rays(self._tensor(both))
        t = answer["t_hit"].numpy().astype(float)
        normal = answer["primitive_normals"].numpy().astype(float)
        cosine = np.abs((normal * way).sum(axis=1)) / np.linalg.norm(way, axis=1)
        return t, cosine, start + np.where(np.isfinite(t), t, 0)[:, None] * way


@dataclass(frozen=True)
class Backdrop:
    """What a camera sees of the still parts, and which of its pixels (indices) may see what turns."""

    T_world_camera: Array
    hits: Hits
    colours: NDArray[np.uint8]
    near: NDArray[np.intp]


@dataclass(frozen=True)
class Stage:
    """Everything that stands still, and what turns. World = the plate's frame: z up, plate at 0, axis x = y = 0."""

    camera: Pinhole
    still: Solid
    plate: Solid
    item: Solid
    paints: tuple[Paint, Paint, Paint]  # of the still parts, the plate, the object
    T_world_camera: Array

    def backdrop(self, T_world_camera: Array) -> Backdrop:
        h, w = self.camera.height, self.camera.width
        rays = self.camera.rays.reshape(-1, 3)
        z, cosine, point = self.still.hit(T_world_camera, rays)
        part = np.where(np.isfinite(z), STILL, NOTHING).astype(np.int8)
        hits = Hits(z.reshape(h, w), part.reshape(h, w), cosine.reshape(h, w), point.reshape(h, w, 3))
        colours = np.full((h, w, 3), 30, np.uint8)
        colours[hits.part == STILL] = self._lit(hits, STILL)
        origin = np.linalg.inv(T_world_camera)[:3, 3]
        along = (rays @ origin) / (rays**2).sum(axis=1)
        reach = max(self.plate.reach, self.item.reach) + 0.02  # an object may be moved on its plate
        near = np.flatnonzero(np.linalg.norm(rays * along[:, None] - origin, axis=1) <= reach)
        return Backdrop(T_world_camera, hits, colours, near)

    def seen(self, backdrop: Backdrop, T_world_plate: Array, T_world_item: Array) -> tuple[Hits, NDArray[np.uint8]]:
        """One frame without noise, and its colours (h, w, 3): paint, lit from the camera's side."""
        at = np.unravel_index(backdrop.near, backdrop.hits.z.shape)
        rays, old = self.camera.rays[at], backdrop.hits
        z, part, cosine, point = old.z[at], old.part[at], old.cosine[at], old.point[at]
        for kind, solid, T in ((PLATE, self.plate, T_world_plate), (OBJECT, self.item, T_world_item)):
            t, c, p = solid.hit(np.linalg.inv(T) @ backdrop.T_world_camera, rays)
            first = t < z
            z[first], cosine[first], point[first], part[first] = t[first], c[first], p[first], kind
        some, colours = Hits(z, part, cosine, point), backdrop.colours.copy()
        patch = colours[at]
        for kind in (PLATE, OBJECT):
            patch[part == kind] = self._lit(some, kind)
        colours[at] = patch
        whole = Hits(old.z.copy(), old.part.copy(), old.cosine.copy(), old.point.copy())
        whole.z[at], whole.part[at], whole.cosine[at], whole.point[at] = z, part, cosine, point
        return whole, colours

    def _lit(self, hits: Hits, kind: int) -> NDArray[np.uint8]:
        mine = hits.part == kind
        colour = self.paints[kind - STILL].at(hits.point[mine]) * (0.35 + 0.65 * hits.cosine[mine])[:, None]
        return np.clip(colour, 0, 255).astype(np.uint8)


def stage_of(
    rng: Rng, camera: Pinhole, item: trimesh.Trimesh, distance: float, looks_down: float | None = None
) -> Stage:
    """A stage round the object: plate, wall at 1.5 to 2.5 m, a camera that looks down by 20 to 35 deg (or as told)."""
    radius = float(np.linalg.norm(item.vertices[:, :2], axis=1).max()) + rng.uniform(0.02, 0.04)
    plate = trimesh.creation.cylinder(radius, PLATE_HEIGHT, sections=96)
    plate.apply_translation([0, 0, -PLATE_HEIGHT / 2])
    down, height = np.deg2rad(rng.uniform(20, 35)), float(item.vertices[:, 2].max())
    if looks_down is not None:
        down = np.deg2rad(looks_down)
    aim = np.array([*rng.uniform(-0.02, 0.02, 2), 0.45 * height])
    centre = aim + distance * np.array([0, -np.cos(down), np.sin(down)])
    still = joined(_surroundings(rng, rng.uniform(1.5, 2.5) + centre[1]))
    paints = (paint(rng, PLAIN, 0.6), paint(rng, WOOD, 0.12), paint(rng, BRIGHT, 0.1))
    return Stage(camera, Solid(still), Solid(plate), Solid(item), paints, _looking(centre, aim))


def _surroundings(rng: Rng, wall_at: float) -> list[trimesh.Trimesh]:
    table = trimesh.creation.box([1.3, 0.9, 0.03])
    table.apply_translation([0, 0, -PLATE_HEIGHT - 0.015])
    floor = trimesh.creation.box([8, 8, 0.02])
    floor.apply_translation([0, 0, -PLATE_HEIGHT - TABLE_HEIGHT])
    wall = trimesh.creation.box([8, 0.02, 6])
    wall.apply_transform(trimesh.transformations.rotation_matrix(rng.uniform(-0.15, 0.15), [0, 0, 1]))
    wall.apply_translation([0, wall_at, 0])
    thing = trimesh.creation.box(rng.uniform([0.06, 0.06, 0.1], [0.12, 0.1, 0.2]))
    thing.apply_transform(trimesh.transformations.rotation_matrix(rng.uniform(0, 1.5), [0, 0, 1]))
    thing.apply_translation([rng.choice([-1, 1]) * rng.uniform(0.4, 0.5), 0.28, -PLATE_HEIGHT - thing.bounds[0, 2]])
    return [table, floor, wall, thing]


def _looking(centre: Array, aim: Array) -> Array:
    """Pose of a camera (x right, y down, z forward) that looks from one point to another, its x level."""
    z = (aim - centre) / np.linalg.norm(aim - centre)
    x = np.cross(z, [0, 0, 1])
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3] = np.stack([x, np.cross(z, x), z, centre], axis=1)
    return T


def turned(degrees: float, centre: tuple[float, float] = (0.0, 0.0)) -> Array:
    """A turn about the upright through `centre`."""
    return np.asarray(trimesh.transformations.rotation_matrix(np.deg2rad(degrees), [0, 0, 1], [*centre, 0]))
