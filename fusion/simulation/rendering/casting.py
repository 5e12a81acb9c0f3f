"""Rays against meshes: Embree, one prepared mesh per body, any number of bodies before one camera."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, inverse
from fusion.mesh.mesh import Mesh
from fusion.simulation.scene.scene import TRANSLUCENT

GREY = 180  # colour of a mesh without colours
BLOCK = 16384  # rays
Floats = NDArray[np.float32]


class PreparedMesh:
    """A mesh prepared for many rays.

    Its reflectance in the infrared is `mesh.scalars["reflectance"]` where it has one; else the mean of the colour's
    channels over 255 (for a coloured mesh that is a guess). `mesh.scalars["translucent"]` is seen where it has one.
    """

    def __init__(self, mesh: Mesh) -> None:
        import open3d as o3d

        self._tensor = o3d.core.Tensor.from_numpy
        self._scene = o3d.t.geometry.RaycastingScene(nthreads=0)  # all cores
        self.faces = mesh.faces
        self.smooth, self.told = mesh.normals is not None, TRANSLUCENT in mesh.scalars
        self.corners = _values(mesh)[mesh.faces]  # (faces, 3, k): one place in memory for each hit
        if len(mesh.faces):
            self._scene.add_triangles(
                self._tensor(np.ascontiguousarray(mesh.vertices, np.float32)),
                self._tensor(np.ascontiguousarray(mesh.faces, np.uint32)),
            )

    def cast(self, rays: Floats) -> tuple[Floats, NDArray[np.uint32], Floats, Floats]:
        """First hits of (n, 6) origins and directions: parameter (inf for none), face, its normal and (u, v)."""
        hits = self._scene.cast_rays(self._tensor(rays))
        names = ("t_hit", "primitive_ids", "primitive_normals", "primitive_uvs")
        return tuple(hits[name].numpy() for name in names)

    def blocks(self, rays: Floats) -> NDArray[np.bool_]:
        """(n,) True where something lies between the origin of a ray and the end of its direction."""
        return self._scene.test_occlusions(self._tensor(rays), 0.0, 1.0).numpy()


@dataclass(frozen=True)
class Body:
    """A mesh and where it stands."""

    mesh: PreparedMesh  # prepared once
    T_world_body: Array = field(default_factory=lambda: np.eye(4))  # (4, 4)
    # (6,) rotation [rad/s] and velocity at the world's origin [m/s], in the world frame; None: at rest
    twist: Array | None = None
    turning: bool = False  # it stands on the turntable


@dataclass(frozen=True)
class Hits:
    """What n rays meet first; `t` is inf where that is nothing, `normals` (n, 3) of the faces, in the camera frame."""

    t: Floats
    normals: Floats
    face: NDArray[np.uint32]
    uv: Floats
    body: NDArray[np.uint8]


@dataclass(frozen=True)
class CastBodies:
    """Bodies before a camera; all rays, points and normals are in the camera frame."""

    bodies: Sequence[Body]
    T_world_camera: Array

    @cached_property
    def placed(self) -> list[tuple[PreparedMesh, Array]]:
        """Each mesh and its T_body_camera."""
        return [(body.mesh, inverse(body.T_world_body) @ self.T_world_camera) for body in self.bodies]

    def first(self, directions: Floats) -> Hits:
        """The first surface along rays (n, 3) from the camera; `t` counts in lengths of the direction."""
        best = None
        for index, (mesh, T) in enumerate(self.placed):
            R = T[:3, :3].astype(np.float32)
            rays = np.empty((len(directions), 6), np.float32)
            rays[:, :3] = T[:3, 3]
            _turn(directions, R, rays[:, 3:])
            t, face, normals, uv = mesh.cast(rays)
            hits = Hits(t, _turn(normals, R.T, np.empty_like(normals)), face, uv, np.full(len(t), index, np.uint8))
            best = hits if best is None else _nearer(best, hits)
        return best if best is not None else _nothing(len(directions))

    def blocked(self, starts: Floats, ends: Floats) -> NDArray[np.bool_]:
        """(n,) True where something stands between `starts` (3,) or (n, 3) and `ends` (n, 3)."""
        shadow = np.zeros(len(ends), bool)
        for mesh, T in self.placed:
            R = T[:3, :3].astype(np.float32)
            rays = np.empty((len(ends), 6), np.float32)
            _turn(np.atleast_2d(starts), R, rays[:, :3])
            rays[:, :3] += T[:3, 3].astype(np.float32)
            _turn(ends - starts, R, rays[:, 3:])
            shadow |= mesh.blocks(rays)
        return shadow

    def values(self, hits: Hits) -> tuple[Floats, Floats]:
        """Red, green, blue [0, 255] and reflectance [1] (n, 4), and unit normals (n, 3) of the surface at the hits.

        Where some mesh tells it there is a fifth column: how translucent the surface is, NaN where it is not known.
        The normals are those of the vertices where a mesh has them. All rays must have hit.
        """
        columns = 5 if any(mesh.told for mesh, _ in self.placed) else 4
        values = np.full((len(hits.t), columns), np.nan, np.float32)
        normals = hits.normals
        for index, (mesh, T) in enumerate(self.placed):
            mine = slice(None) if len(self.placed) == 1 else np.flatnonzero(hits.body == index)
            found = _interpolated(mesh, hits.face[mine], hits.uv[mine])
            values[mine, :4] = found[:, :4]
            if mesh.told:
                values[mine, 4] = found[:, -1]
            if mesh.smooth:
                normals = normals if normals is not hits.normals else normals.copy()
                smooth = _turn(found[:, 4:7], T[:3, :3].T.astype(np.float32), np.empty((len(found), 3), np.float32))
                normals[mine] = _unit(smooth, normals[mine])
        return values, normals


@lru_cache(maxsize=2)
def directions(camera: Camera) -> Floats:
    """(pixels, 3) rays of all pixels in the camera frame, of length 1 along z; read only."""
    rays = np.dstack([camera.rays(), np.ones(camera.shape, np.float32)]).reshape(-1, 3)
    rays.flags.writeable = False
    return rays


def _values(mesh: Mesh) -> Floats:
    """(vertices, 4 to 8) red, green, blue, reflectance and, where there are some, normals and how translucent it is."""
    colors = np.full(mesh.vertices.shape, GREY, np.uint8) if mesh.colors is None else mesh.colors
    reflectance = mesh.scalars.get("reflectance", colors.mean(axis=1) / 255.0)
    parts = [colors, np.reshape(reflectance, (-1, 1))]
    parts += [] if mesh.normals is None else [mesh.normals]
    parts += [mesh.scalars[TRANSLUCENT][:, None]] if TRANSLUCENT in mesh.scalars else []
    return np.hstack(parts).astype(np.float32)


def _interpolated(mesh: PreparedMesh, face: NDArray[np.uint32], uv: Floats) -> Floats:
    """Values (n, 4 to 8) at hits, a block at a time, so that it stays in the processor's cache."""
    found = np.empty((len(face), mesh.corners.shape[2]), np.float32)
    for start in range(0, len(face), BLOCK):
        block = slice(start, start + BLOCK)
        u, v = uv[block, :1], uv[block, 1:]
        corners = mesh.corners[face[block]]
        np.multiply(corners[:, 0], 1 - u - v, out=found[block])
        found[block] += corners[:, 1] * u
        found[block] += corners[:, 2] * v
    return found


def _turn(vectors: Floats, R: Floats, out: Floats) -> Floats:
    """Vectors (n, 3) or (1, 3) turned by R into `out` (n, 3); many threads for so small a matrix would only wait."""
    for row in range(3):
        column = vectors[:, 0] * R[row, 0]
        column += vectors[:, 1] * R[row, 1]
        column += vectors[:, 2] * R[row, 2]
        out[:, row] = column
    return out


def _unit(normals: Floats, flat: Floats) -> Floats:
    """Unit vectors (n, 3); the flat ones where the smooth ones cancel out."""
    length = np.sqrt(np.einsum("nk,nk->n", normals, normals))[:, None]
    return np.divide(normals, length, out=flat.copy(), where=length > 1e-6)


def _nearer(a: Hits, b: Hits) -> Hits:
    take = b.t < a.t
    pairs = ((a.t, b.t), (a.normals, b.normals), (a.face, b.face), (a.uv, b.uv), (a.body, b.body))
    for old, new in pairs:
        old[take] = new[take]
    return a


def _nothing(n: int) -> Hits:
    none = np.zeros(n, np.uint8)
    return Hits(
        np.full(n, np.inf, np.float32),
        np.zeros((n, 3), np.float32),
        none.astype(np.uint32),
        np.zeros((n, 2), np.float32),
        none,
    )
