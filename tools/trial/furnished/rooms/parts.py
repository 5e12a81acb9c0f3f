"""Parts of a scene: a mesh with a reflectance for each triangle."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[Any]


@dataclass(frozen=True)
class ScenePart:
    """Attributes:
    mesh: vertices [m].
    reflectance: (triangles,) 0.02 to 1, in the steps of a colour of 8 bits.
    name: what it is.
    """

    mesh: Any
    reflectance: Array
    name: str


@dataclass(frozen=True)
class MergedParts:
    """All parts as one mesh, in which no two triangles share a vertex.

    Attributes:
        vertices: (3 n, 3) [m], float32.
        faces: (n, 3).
        reflectance: (n,).
        part: (n,) index of the part of each triangle.
    """

    vertices: Array
    faces: Array
    reflectance: Array
    part: Array


@dataclass(frozen=True)
class Furnished:
    """A scene. `eye` and `aim`: for x, y, z the least and the largest [m] of where cameras stand and look."""

    parts: list[ScenePart]
    eye: list[tuple[float, float]]
    aim: list[tuple[float, float]]
    kind: str


def part(mesh: Any, reflectance: Any, name: str) -> ScenePart:
    """`reflectance`: a number, or one for each triangle."""
    each = np.full(len(mesh.faces), 1.0) * reflectance if np.ndim(reflectance) == 0 else np.asarray(reflectance)
    steps = np.round(np.clip(np.asarray(each, float), 0.02, 1) * 255) / 255
    return ScenePart(mesh.copy(), steps, name)


def grid(
    corner: Any,
    along: Any,
    up: Any,
    cells: tuple[int, int],
    reflectance: Any,
    name: str,
    height: Callable[[Array, Array], Array] | None = None,
) -> ScenePart:
    """Rectangle corner + a along + b up.

    Args:
        corner, along, up: (3,) [m].
        cells: how many along and up.
        reflectance: a number, or (up, along) numbers.
        height: of a and b from 0 to 1, [m] along the normal.
    """
    corner, along, up = (np.asarray(x, float) for x in (corner, along, up))
    nx, ny = cells
    a, b = np.meshgrid(np.linspace(0, 1, nx + 1), np.linspace(0, 1, ny + 1))
    vertices = corner + a[..., None] * along + b[..., None] * up
    if height is not None:
        normal = np.cross(along, up)
        normal /= np.linalg.norm(normal)
        vertices = vertices + height(a, b)[..., None] * normal
    index = np.arange((nx + 1) * (ny + 1)).reshape(ny + 1, nx + 1)
    corners = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], -1).reshape(-1, 4)
    faces = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
    each = np.broadcast_to(reflectance, (ny, nx)).reshape(-1)
    mesh = trimesh.Trimesh(vertices.reshape(-1, 3), faces, process=False)
    return part(mesh, np.concatenate([each, each]), name)


def box(
    centre: Sequence[float],
    size: Any,
    turned: Rotation,
    reflectance: float,
    name: str,
    rng: np.random.Generator | None = None,
) -> ScenePart:
    """Its faces differ in reflectance where there is an `rng`."""
    mesh = trimesh.creation.box(extents=size)
    mesh.apply_transform(_placed(turned, centre))
    faces = rng.uniform(0.8, 1.15, 6) if rng is not None else np.ones(6)
    return part(mesh, np.repeat(reflectance * faces, 2), name)


def yaw(angle: float) -> Rotation:
    return Rotation.from_euler("z", angle)


def cylinder(
    centre: Sequence[float],
    radius: float,
    height: float,
    reflectance: float,
    name: str,
    turned: Rotation | None = None,
) -> ScenePart:
    mesh = trimesh.creation.cylinder(radius=radius, height=height, sections=40)
    mesh.apply_transform(_placed(turned, centre))
    return part(mesh, reflectance, name)


def ball(centre: Sequence[float], radius: float, reflectance: float, name: str) -> ScenePart:
    mesh = trimesh.creation.icosphere(subdivisions=4, radius=radius)
    mesh.apply_translation(centre)
    return part(mesh, reflectance, name)


def merge(parts: Sequence[ScenePart]) -> MergedParts:
    vertices = np.concatenate([p.mesh.vertices[p.mesh.faces].reshape(-1, 3) for p in parts]).astype(np.float32)
    reflectance = np.concatenate([p.reflectance for p in parts])
    index = np.concatenate([np.full(len(p.reflectance), i) for i, p in enumerate(parts)])
    return MergedParts(vertices, np.arange(len(vertices)).reshape(-1, 3), reflectance, index)


def _placed(turned: Rotation | None, centre: Sequence[float]) -> Array:
    T = np.eye(4)
    if turned is not None:
        T[:3, :3] = turned.as_matrix()
    T[:3, 3] = centre
    return T
