"""What a camera sees of items that stand still: ray casting by Open3D (Embree), one ray per pixel."""

import importlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from tools.sets.loop_scenes.place.pieces import Item, joined
from tools.sets.loop_scenes.place.prints import Array


@dataclass(frozen=True)
class Lens:
    """A pinhole; the centre of the top-left pixel is (0, 0)."""

    width: int
    height: int
    f: float

    @property
    def centre(self) -> tuple[float, float]:
        return (self.width - 1) / 2, (self.height - 1) / 2

    @cached_property
    def rays(self) -> NDArray[np.float32]:
        """(h, w, 3) directions with z = 1: lengths along them are depths."""
        v, u = np.mgrid[: self.height, : self.width]
        cx, cy = self.centre
        return np.stack([(u - cx) / self.f, (v - cy) / self.f, np.ones(u.shape)], axis=-1).astype(np.float32)


@dataclass(frozen=True)
class View:
    """Of each pixel (h, w): depth [m] (inf: nothing), angle of incidence [rad], what it is, colour (h, w, 3)."""

    z: Array
    incidence: Array
    dark: NDArray[np.bool_]
    shell: NDArray[np.bool_]
    colour: Array


class Scenery:
    """Items in the world, z up."""

    def __init__(self, items: Sequence[Item]) -> None:
        self.items = list(items)
        o3d: Any = importlib.import_module("open3d")  # its type stubs reject what it takes
        self._tensor = o3d.core.Tensor
        self._scene: Any = o3d.t.geometry.RaycastingScene()
        for item in self.items:
            vertices = self._tensor(np.asarray(item.mesh.vertices, np.float32))
            self._scene.add_triangles(vertices, self._tensor(np.asarray(item.mesh.faces, np.uint32)))

    @property
    def mesh(self) -> trimesh.Trimesh:
        """All in one."""
        return joined([item.mesh for item in self.items])

    def seen(self, lens: Lens, T_world_camera: Array) -> View:
        """One frame, without noise; lit from beside the camera, with some light from everywhere."""
        rays = self._cast(lens, T_world_camera)
        answer = self._scene.cast_rays(rays, 0)
        z = answer["t_hit"].numpy().astype(float)
        start, way = np.split(rays.numpy().astype(float).reshape(-1, 6), 2, axis=1)
        normal = answer["primitive_normals"].numpy().reshape(-1, 3)
        cosine = np.abs((normal * way).sum(axis=1)) / np.linalg.norm(way, axis=1)
        points = start + np.where(np.isfinite(z), z, 0).reshape(-1, 1) * way
        which = answer["geometry_ids"].numpy().ravel()
        colour, dark, shell = np.full((len(way), 3), 24.0), np.zeros(len(way), bool), np.zeros(len(way), bool)
        for number, item in enumerate(self.items):
            mine = np.flatnonzero(which == number)
            if len(mine):
                colour[mine] = item.print.at(points[mine]) * (0.45 + 0.55 * cosine[mine, None])
                dark[mine], shell[mine] = item.dark, item.shell
        incidence = np.arccos(np.clip(cosine, 0, 1)).reshape(z.shape)
        return View(z, incidence, dark.reshape(z.shape), shell.reshape(z.shape), colour.reshape(*z.shape, 3))

    def _cast(self, lens: Lens, T: Array) -> Any:
        way = lens.rays @ T[:3, :3].T.astype(np.float32)
        start = np.broadcast_to(T[:3, 3].astype(np.float32), way.shape)
        return self._tensor(np.concatenate([start, way], axis=-1))
