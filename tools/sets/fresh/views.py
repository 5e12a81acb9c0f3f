"""What stands before the camera: a wall, a board, or an object on a table. All say what a bundle of rays meets."""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tools.sets.planted.shapes import Waves
from tools.sets.planted.stage import Solid

Array = NDArray[np.float64]

NOTHING, STILL, PLATE, OBJECT = range(4)
COLUMNS, ROWS, SQUARE = 9, 6, 0.04  # inner corners of the board, and the edge of a square [m]
MARGIN = 1.25  # squares of white round the outer squares


@dataclass(frozen=True)
class View:
    """Per ray (h, w): z [m] (inf where nothing), cosine of incidence, reflectance, part."""

    z: Array
    cosine: Array
    reflectance: Array
    part: NDArray[np.int8]


class Scene(Protocol):
    """Rays (h, w, 3) with z = 1, in the camera's frame."""

    def look(self, rays: Array) -> View: ...


@dataclass(frozen=True)
class Plane:
    """A wall without end: normal (3,) towards the camera, `z` on the optical axis [m]."""

    normal: Array
    z: float
    reflectance: float = 0.8

    def look(self, rays: Array) -> View:
        facing = rays @ self.normal
        z = self.z * self.normal[2] / facing
        cosine = np.abs(facing) / np.linalg.norm(rays, axis=-1)
        hit = (facing < 0) & (z > 0)
        whole = np.full(z.shape, self.reflectance)
        return View(np.where(hit, z, np.inf), cosine, whole, np.where(hit, STILL, NOTHING).astype(np.int8))


@dataclass(frozen=True)
class Board:
    """A checkerboard with nothing behind; T (4, 4) board to camera, its origin the first inner corner, z away."""

    T: Array

    @property
    def corners(self) -> Array:
        """(rows * columns, 3) in the camera's frame."""
        v, u = np.mgrid[:ROWS, :COLUMNS]
        flat = np.stack([u, v, np.zeros(u.shape)], axis=-1).reshape(-1, 3) * SQUARE
        return np.asarray(flat @ self.T[:3, :3].T + self.T[:3, 3])

    def look(self, rays: Array) -> View:
        n = self.T[:3, 2]
        facing = rays @ n
        z = (self.T[:3, 3] @ n) / facing
        at = (z[..., None] * rays - self.T[:3, 3]) @ self.T[:3, :2] / SQUARE
        s, t = at[..., 0], at[..., 1]
        inside = (s > -1) & (s < COLUMNS) & (t > -1) & (t < ROWS)
        edge = 1 + MARGIN
        hit = (z > 0) & (s > -edge) & (s < COLUMNS - 1 + edge) & (t > -edge) & (t < ROWS - 1 + edge)
        dark = inside & ((np.floor(s) + np.floor(t)) % 2 == 0)
        cosine = np.abs(facing) / np.linalg.norm(rays, axis=-1)
        part = np.where(hit, STILL, NOTHING).astype(np.int8)
        return View(np.where(hit, z, np.inf), cosine, np.where(hit, np.where(dark, 0.1, 0.85), 0.0), part)


@dataclass(frozen=True)
class Table:
    """An object on a disc. Frame: the disc's, z up, disc at z = 0. T (4, 4) camera to that frame."""

    plate: Solid
    item: Solid
    print: Waves
    T: Array

    def at(self, T: Array) -> "Table":
        """Seen from elsewhere."""
        return replace(self, T=T)

    def look(self, rays: Array) -> View:
        shape = rays.shape[:2]
        z, cosine, reflectance = np.full(shape, np.inf), np.ones(shape), np.zeros(shape)
        part = np.zeros(shape, np.int8)
        centre = -self.T[:3, :3].T @ self.T[:3, 3]
        beside = np.linalg.norm(np.cross(rays, centre), axis=-1) / np.linalg.norm(rays, axis=-1)
        near = beside <= max(self.plate.reach, self.item.reach)
        for kind, solid in ((PLATE, self.plate), (OBJECT, self.item)):
            t, c, point = solid.hit(self.T, rays[near])
            first = t < z[near]
            light = 0.55 + 0.2 * np.sign(self.print.at(point)) if kind == OBJECT else np.full(t.shape, 0.5)
            for image, new in ((z, t), (cosine, c), (reflectance, light)):
                image[near] = np.where(first, new, image[near])
            part[near] = np.where(first, kind, part[near])
        return View(z, cosine, reflectance, part)
