"""The object cut off the plate it stands on, where noise parts the two, and its sides carried down to the plate.

A surface is known to its noise, and in the corner between side and plate to a voxel: nearer to the plate than both,
what is object and what is plate cannot be told. Above that the sides were seen; below they go on as they came.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fusion.geometry.robust import MAD_TO_STD, tukey
from fusion.mesh.cleanup import border_edges, large_parts
from fusion.mesh.clipping import clipped
from fusion.mesh.mesh import Mesh
from fusion.mesh.shape import CRUMB
from fusion.turntable.table.plate import NEAR_PLATE
from fusion.turntable.table.slab import HALFWAY

Array = NDArray[np.float64]
FITTED = 0.04  # of the size, off the plate's surface up to which vertices take part in its last fit (guess)
THERE = 0.1  # share of what is level, so far off z = 0, by which the plate is where it was found (guess)
FAR = 7.0  # median deviations: 5 standard deviations of normal noise
HIGHEST = 99.5  # percentile of them that hardly any is higher by
FEWEST = 100  # level vertices that make a plate
STEEP = 0.7  # largest upright part of a side's normal: what is flatter is a top
FLATTEST = 0.9  # where a side is flatter than that, where it meets the plate is not known
LEVEL = 1e-5  # [m] on the cut: rounding of single precision
HIGHER = 1.2  # the next cut that is tried
ROUNDED = (
    0.006  # [m] above a plate blur reaches at most, or 4 voxels; what is rounded above is the object's own (guess)
)
ABOVE = (0.001, 0.004)  # [m] above a cut the side is compared with it: below is the plate's noise
BENDS = 3.0  # standard errors from which a side bends more than it does higher up: one cut of a thousand by chance
TOGETHER = 4  # vertices whose normals noise turns alike: those of neighbouring voxels (guess)
SOME = 500  # places around that are asked


@dataclass(frozen=True)
class FittedPlate:
    """A plate in the object's frame: z = c + a x + b y + k r^2, and how far above it nothing can be told from it [m].

    It need not be square to the axis, and a camera that is not calibrated bends it.
    """

    terms: Array
    hidden: float

    def height(self, points: Array) -> Array:
        """(n,) of points (n, 3) above it [m]."""
        return np.asarray(points[:, 2] - _terms(points) @ self.terms)


def fitted_plate(mesh: Mesh, voxel: float, size: float, table: float | None = None) -> FittedPlate:
    """The plate near z = 0 by its level vertices; z = 0 itself where too few are seen.

    Args:
        mesh: of an object's frame, with normals.
        voxel: that it was made with [m].
        size: of what turns [m].
        table: height of the table below a plate that turns, seen beside it [m].
    """
    assert mesh.normals is not None
    near, fitted = NEAR_PLATE * size, max(FITTED * size, voxel)
    near = near if table is None else min(near, HALFWAY * abs(table))
    level = np.flatnonzero((mesh.normals[:, 2] > 0.9) & (np.abs(mesh.vertices[:, 2]) < near))
    # where it was found is much that is level: else the table beside a thin plate, which is wider, would stand for it
    if len(level) and np.mean(np.abs(mesh.vertices[level, 2]) < fitted) > THERE:
        near = min(near, 2 * fitted)
        level = level[np.abs(mesh.vertices[level, 2]) < near]
    if len(level) < FEWEST:
        return FittedPlate(np.zeros(4), fitted)
    level = level[:: max(1, len(level) // 20_000)]
    A, height = _terms(mesh.vertices[level]), mesh.vertices[level, 2]
    fit = np.array([np.median(height), 0, 0, 0])
    for scale in np.geomspace(near, min(fitted, near), 12):
        weight = tukey((height - A @ fit) / scale, cut=1.0)
        # the bend and the tilt must not run away where the plate is hardly seen
        ridge = 1e-3 * max(float(np.sum(weight)), 1.0) * np.diag([0, 1e-3, 1e-3, 1e-4])
        fit = np.linalg.solve((A * weight[:, None]).T @ A + ridge, A.T @ (weight * height))
    return FittedPlate(fit, float(np.hypot(voxel, _noise(A @ fit - height, voxel))))


def _noise(below: Array, voxel: float) -> float:
    """As far [m] as the plate lies above its fit, by how far it lies below: there is no low part of the object.

    Coarse counts have a median of about zero and long tails; what lies far below is the table beside the plate.
    """
    below = below[below > 0]
    if not len(below):
        return 0.0
    own = below < max(FAR * float(np.median(below)), voxel)
    return float(np.percentile(below[own], HIGHEST))


def clear_of_rounding(mesh: Mesh, plate: FittedPlate, voxel: float) -> FittedPlate:
    """The plate with `hidden` as high as blur rounds the corner between it and what stands on it.

    Pixels, windows and filters see side and plate together. So a side bends outwards where it meets the plate: the cut
    goes up until the side bends no more than it does above all that blur reaches, where what it does is its own.
    """
    cut, most = plate.hidden, max(ROUNDED, 4 * voxel)
    height = plate.height(mesh.vertices)
    own = _bend(mesh, height, 1.5 * most, most) or _Bend(0.0, 0.0)
    while cut < most:
        found = _bend(mesh, height, cut, voxel)
        if found is None or found.size - own.size <= BENDS * np.hypot(found.error, own.error):
            break
        cut *= HIGHER
    return replace(plate, hidden=min(cut, max(most, plate.hidden)))


@dataclass(frozen=True)
class _Bend:
    """By how much the upright part of a side's normal is more than a little higher up: median, standard error."""

    size: float
    error: float


def _bend(mesh: Mesh, height: Array, at: float, thick: float) -> _Bend | None:
    """Of a band so thick [m] about a height, of vertices (n,) above the plate [m]; None where there is no side."""
    assert mesh.normals is not None
    upright = mesh.normals[:, 2].astype(float)
    band = np.flatnonzero(np.abs(height - at) < thick / 2)
    band = band[:: max(1, len(band) // SOME)]
    over = np.flatnonzero((height > at + ABOVE[0]) & (height < at + thick / 2 + ABOVE[1]))
    if not len(band) or not len(over):
        return None
    around = cKDTree(mesh.vertices[over]).query_ball_point(mesh.vertices[band], 1.5 * ABOVE[1])
    bends = np.array([upright[i] - upright[over[near]].mean() for i, near in zip(band, around, strict=True) if near])
    if not len(bends):
        return None
    middle = float(np.median(bends))
    spread = MAD_TO_STD * float(np.median(np.abs(bends - middle)))
    return _Bend(middle, spread * np.sqrt(np.pi / 2 * TOGETHER / len(bends)))


def off_plate(mesh: Mesh, plate: FittedPlate) -> tuple[Mesh, float]:
    """The object alone, standing on its plate, and the share of the surface above the plate that its parts hold."""
    mesh, kept = large_parts(clipped(mesh, plate.height(mesh.vertices) - plate.hidden), CRUMB)
    return (carried_down(mesh, plate) if len(mesh.faces) else mesh), kept


def carried_down(mesh: Mesh, plate: FittedPlate) -> Mesh:
    """The sides that end at the cut go on to the plate as they came, by a strip of triangles.

    Where they come too flat to say where they end, the border stays where it was seen.
    """
    assert mesh.normals is not None
    ends = border_edges(mesh)
    on_cut = np.abs(plate.height(mesh.vertices) - plate.hidden) < LEVEL
    ends = ends[on_cut[ends].all(axis=1)]
    ring = np.unique(ends)
    normals = _of_sides(mesh, ring, 2 * plate.hidden)
    steep = np.abs(normals[:, 2]) < FLATTEST
    ends = ends[np.isin(ends, ring[steep]).all(axis=1)]
    ring, normals = ring[steep], normals[steep]
    if not len(ends):
        return mesh
    down = np.array([0.0, 0.0, -1.0]) + normals[:, 2:] * normals
    foot = mesh.vertices[ring] + down * (plate.hidden / np.maximum(-down[:, 2:], 1e-9))
    foot[:, 2] -= plate.height(foot)  # the plate is not quite level
    index = np.full(len(mesh.vertices), -1)
    index[ring] = len(mesh.vertices) + np.arange(len(ring))
    start, end = ends.T
    strip = [np.stack([end, start, index[start]], axis=1), np.stack([end, index[start], index[end]], axis=1)]
    return replace(
        mesh,
        vertices=np.concatenate([mesh.vertices, foot]),
        faces=np.concatenate([mesh.faces, *strip]).astype(np.int32),
        normals=np.concatenate([mesh.normals, normals.astype(np.float32)]),
        colors=None if mesh.colors is None else np.concatenate([mesh.colors, mesh.colors[ring]]),
        scalars={name: np.concatenate([values, values[ring]]) for name, values in mesh.scalars.items()},
    )


def _of_sides(mesh: Mesh, ring: NDArray[np.intp], reach: float) -> Array:
    """(k, 3) unit normals of the side above each of the vertices `ring`, mean within a reach [m]; tops are left out."""
    assert mesh.normals is not None
    own = mesh.normals.astype(float)
    side = np.flatnonzero(np.abs(own[:, 2]) < STEEP)
    around = (
        cKDTree(mesh.vertices[side]).query_ball_point(mesh.vertices[ring], reach) if len(side) else [[]] * len(ring)
    )
    mean = np.array([own[side[near]].mean(axis=0) if near else own[i] for near, i in zip(around, ring, strict=True)])
    mean = mean.reshape(-1, 3)
    return np.asarray(mean / np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-12))


def _terms(points: Array) -> Array:
    x, y, _ = points.T
    return np.column_stack([np.ones_like(x), x, y, x**2 + y**2])
