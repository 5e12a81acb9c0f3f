"""Light that reaches the object by way of the plate: time of flight sees the sides too far in, most near the plate.

No view of the scan tells: as the incidence gets flatter such light adds more to the range, and along the normal all
views are wrong by the same. So one bounce is computed, for a plate that reflects as much as is told.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.mesh.mesh import Mesh
from fusion.recording.ahead import ahead
from fusion.sensor.effects.light.multipath import Multipath
from fusion.simulation.rendering.casting import Body
from fusion.simulation.rendering.indirect import Bounce
from fusion.simulation.rendering.render import Channels, RayCaster, view_of
from fusion.volume.prepared import Prepared

Array = NDArray[np.float64]
USUAL = 0.5  # of the light that a plate of wood or plastic reflects (guess)
FRAMES = 12  # evenly from the scan
FACING = 0.2  # least cosine of the incidence at which a view counts
SEEN = 0.003  # [m] a place is what a pixel sees when it lies so near: a pixel's noise and width
LIGHT = Channels(indirect=Bounce(cell_px=8, beyond=0.0))  # the picture holds the plate
CORNERS = 96
# [m] of the plate about the axis; what lies so near its height is the plate. Absolute: as plates are made, and bent by
# a camera's noise
RING, FARTHEST, LEVEL = 0.01, 0.5, 0.006


@dataclass(frozen=True)
class PlateLight:
    """By how much the surface seems to lie too far in."""

    offset: Array  # (n,) of each vertex [m]
    reflectance: float  # of the plate, told or usual
    taken_out: bool  # the vertices were moved out by it, as it was told how much the plate reflects

    def __str__(self) -> str:
        largest, mean = 1e3 * float(np.percentile(self.offset, 95)), 1e3 * float(self.offset.mean())
        size = f"up to {largest:.1f} mm ({mean:.1f} mm in the mean)"
        if self.taken_out:
            return f"light by way of a plate that reflects {self.reflectance:.0%} was taken out of the surface: {size}"
        return (
            f"light by way of the plate makes sides look too far in, by {size} if the plate reflects "
            f"{self.reflectance:.0%}: lay something black on it, or pass --plate-reflectance"
        )


def plate_light(
    mesh: Mesh, frames: Sequence[Prepared | None], poses: Array, radius: float, told: float | None = None
) -> PlateLight:
    """What the plate's light does to a surface.

    Args:
        mesh: the object with normals, its plate at z = 0.
        frames: (n) that it was made of.
        poses: (n, 4, 4) `T_object_camera`.
        radius: of the plate [m].
        told: share of the light that the plate reflects; None takes the usual one.
    """
    reflectance = USUAL if told is None else told
    bodies = (Body(RayCaster(_reflecting(mesh, 0.0))), Body(RayCaster(_reflecting(_disc(radius), reflectance))))
    assert mesh.normals is not None
    normals = mesh.normals.astype(float)
    total, weights = np.zeros(len(normals)), np.full(len(normals), 1e-9)
    placed = [(f, T) for f, T in zip(frames, poses, strict=True) if f is not None and np.isfinite(T).all()]

    def lit(k: int) -> tuple[NDArray[np.intp], Array, Array]:
        """Vertices that a frame shows, by how much they lie too far in, and how much that counts."""
        frame, T = placed[k]
        camera = frame.surface.camera
        view = view_of(bodies, camera, T, LIGHT)
        assert view.depth is not None
        longer = np.nan_to_num(Multipath(1.0).bias(view.depth, view))
        local = pose.transform(pose.inverse(T), mesh.vertices)
        cosine = -np.einsum("ij,ij->i", normals @ T[:3, :3], local) / np.linalg.norm(local, axis=1)
        towards = np.flatnonzero(cosine > FACING)  # to ask a lens where a point is seen is slow
        u, v = np.rint(np.clip(camera.project(local[towards]), -9, 99999)).astype(int).T
        inside = (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
        at, u, v = towards[inside], u[inside], v[inside]
        near = np.abs(view.depth[v, u] - local[at, 2]) < SEEN
        at, u, v = at[near], u[near], v[near]
        stretch = np.linalg.norm(local[at], axis=1) / local[at, 2]
        return at, longer[v, u] * stretch * cosine[at], cosine[at] ** 2

    some = np.unique(np.linspace(0, len(placed) - 1, FRAMES).round().astype(int))
    for shown in ahead(lit, some.tolist()):
        at, off, weight = shown()
        total[at] += weight * off
        weights[at] += weight
    return PlateLight(total / weights, reflectance, told is not None)


def plate_reach(depth: NDArray[np.float32], camera: Camera, T_object_camera: Array, least: float) -> float:
    """Radius of the plate at z = 0 [m], on the camera's side, where nothing stands before it; at least `least` [m].

    Args:
        depth: (h, w) one whole frame [m].
    """
    centre = T_object_camera[:3, 3]
    height = pose.transform(T_object_camera, camera.points(depth).reshape(-1, 3).astype(float))[:, 2]
    rays = np.dstack([camera.rays(), np.ones(camera.shape)]).reshape(-1, 3) @ T_object_camera[:3, :3].T
    with np.errstate(all="ignore"):
        met = centre + rays * (-centre[2] / rays[:, 2])[:, None]
    towards = met[:, :2] @ centre[:2] / np.hypot(*centre[:2])
    reach = np.hypot(met[:, 0], met[:, 1])
    asked = (rays[:, 2] < 0) & (towards > 0.5 * reach) & (reach < FARTHEST) & np.isfinite(height)
    ring = (reach[asked] / RING).astype(int)
    count, level = (np.bincount(ring, w, int(FARTHEST / RING)) for w in (None, np.abs(height[asked]) < LEVEL))
    first = int(np.ceil(least / RING))
    ends = np.flatnonzero((level < 0.5 * count) | (count == 0))
    ends = ends[ends >= first]
    return RING * float(ends[0]) if len(ends) and ends[0] > first else max(least, FARTHEST if not len(ends) else 0.0)


def without(mesh: Mesh, light: PlateLight) -> Mesh:
    """The mesh with its vertices where they lie without that light."""
    assert mesh.normals is not None
    return replace(mesh, vertices=mesh.vertices + mesh.normals * light.offset[:, None].astype(mesh.vertices.dtype))


def _reflecting(mesh: Mesh, share: float) -> Mesh:
    return Mesh(
        mesh.vertices, mesh.faces, mesh.normals, scalars={"reflectance": np.full(len(mesh.vertices), share, np.float32)}
    )


def _disc(radius: float) -> Mesh:
    angle = np.arange(CORNERS) / CORNERS * 2 * np.pi
    rim = radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(CORNERS)])
    k = np.arange(CORNERS)
    faces = np.column_stack([np.zeros(CORNERS), 1 + k, 1 + (k + 1) % CORNERS])
    return Mesh(np.vstack([np.zeros(3), rim]), faces.astype(np.int32))
