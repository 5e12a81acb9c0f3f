"""The mean of several surfaces, and how far they spread about it."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.geometry.robust import robust_std
from fusion.mesh.comparison.distances import Surface, surface_of
from fusion.mesh.comparison.surface_samples import SurfaceSamples, face_areas, sample_surface, vertex_normals
from fusion.mesh.mesh import Mesh
from fusion.repeatability.together import SAME_SIDE, Together

Array = NDArray[np.float64]
SAMPLES = 40_000  # points of the mean surface, even per area, that all numbers are about
GROSS = 8.0  # robust standard deviations beyond which a scan shows another thing there, another place, or none
MUTUAL = 0.5  # least share of a distance that the way back is long: less ends on another part (guess)
SPREAD, COUNT = "spread", "scans"  # scalars of the mean surface: standard deviation [m], how many scans show it


@dataclass(frozen=True)
class ScanSpread:
    """Scans about their mean."""

    mean: Mesh  # the mean surface in the common frame, with the scalars "spread" [m] and "scans"
    at: SurfaceSamples  # m places of it, even per area
    offsets: Array  # (m, n) how far each scan lies outside the mean there [m]; NaN where it has nothing
    carrier: int  # index of the scan whose triangles the mean has


def spread_of(meshes: list[Mesh], together: Together) -> ScanSpread:
    """Mean and spread; the triangles are those of the largest scan, moved onto the mean of all."""
    carrier = int(np.argmax([face_areas(mesh).sum() for mesh in meshes]))
    own, T = meshes[carrier], together.poses[carrier]
    normals = vertex_normals(own) if own.normals is None else own.normals.astype(float)
    mean = Mesh(pose.transform(T, own.vertices), own.faces, (normals @ T[:3, :3].T).astype(np.float32), own.colors)
    offsets = offsets_at(_vertices(mean), surface_of(mean), together)
    moved = np.nan_to_num(_mean(offsets))
    assert mean.normals is not None
    mean = replace(mean, vertices=mean.vertices + moved[:, None] * mean.normals.astype(float))
    surface = surface_of(mean)
    offsets = offsets_at(_vertices(mean), surface, together)
    known = np.isfinite(offsets).sum(axis=1)
    std = np.where(known > 1, _std(offsets), np.nan)
    mean = replace(mean, scalars={SPREAD: std.astype(np.float32), COUNT: known.astype(np.float32)})
    at = sample_surface(mean, SAMPLES)
    return ScanSpread(mean, at, offsets_at(at, surface, together), carrier)


def _vertices(mesh: Mesh) -> SurfaceSamples:
    assert mesh.normals is not None
    return SurfaceSamples(mesh.vertices, mesh.normals.astype(float))


def offsets_at(at: SurfaceSamples, mean: Surface, together: Together) -> Array:
    """(m, n) how far each scan lies outside of points of a mean surface [m]; NaN where it has no surface.

    Near is what two scans show so far off; what is further off is another place of the same surface (a difference) if
    nothing of the mean is nearer to it and both look the same way, else it belongs to another part.
    """
    assert at.normals is not None
    found = []
    for T, surface in zip(together.poses, together.surfaces, strict=True):
        found.append(surface.closest(pose.transform(pose.inverse(T), at.points)))
    ends = np.column_stack([one.on_border for one in found])
    two = (~ends).sum(axis=1) > 1  # one alone is what the mean is made of there: it tells nothing of how far scans lie
    columns = []
    for T, one, border in zip(together.poses, found, ends.T, strict=True):
        away, known = np.abs(one.distances), two & ~border
        usual = robust_std(one.distances[known]) if known.any() else 0.0
        shown = ~border & (away < GROSS * usual + 1e-6)
        far = np.flatnonzero(~border & ~shown)
        back = np.abs(mean.closest(pose.transform(T, one.points[far])).distances)
        facing = np.einsum("ij,ij->i", one.normals[far] @ T[:3, :3].T, at.normals[far])
        shown[far] = (back > MUTUAL * away[far]) & (facing > SAME_SIDE)
        columns.append(np.where(shown, -one.distances, np.nan))
    return np.column_stack(columns)


def _mean(offsets: Array) -> Array:
    known = np.isfinite(offsets)
    return np.asarray(np.where(known, offsets, 0).sum(axis=1) / np.maximum(known.sum(axis=1), 1))


def _std(offsets: Array) -> Array:
    known = np.isfinite(offsets)
    squares = np.where(known, (offsets - _mean(offsets)[:, None]) ** 2, 0).sum(axis=1)
    return np.asarray(np.sqrt(squares / np.maximum(known.sum(axis=1) - 1, 1)))
