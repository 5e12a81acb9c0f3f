"""The mean of several surfaces, and how far they spread about it."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.geometry.robust import robust_std
from fusion.mesh.comparison.surface_samples import face_areas, sample_surface, vertex_normals
from fusion.mesh.mesh import Mesh
from fusion.repeatability.together import Together

Array = NDArray[np.float64]
SAMPLES = 40_000  # points of the mean surface, even per area, that all numbers are about
GROSS = 8.0  # robust standard deviations beyond which a scan shows another thing there, or none
SPREAD, COUNT = "spread", "scans"  # scalars of the mean surface: standard deviation [m], how many scans show it


@dataclass(frozen=True)
class ScanSpread:
    """Scans about their mean."""

    mean: Mesh  # the mean surface in the common frame, with the scalars "spread" [m] and "scans"
    # (m, n) how far each scan lies outside the mean at points even per area [m]; NaN where it has nothing
    offsets: Array
    carrier: int  # index of the scan whose triangles the mean has


def spread_of(meshes: list[Mesh], together: Together) -> ScanSpread:
    """Mean and spread; the triangles are those of the largest scan, moved onto the mean of all."""
    carrier = int(np.argmax([face_areas(mesh).sum() for mesh in meshes]))
    own, T = meshes[carrier], together.poses[carrier]
    normals = vertex_normals(own) if own.normals is None else own.normals.astype(float)
    mean = Mesh(pose.transform(T, own.vertices), own.faces, (normals @ T[:3, :3].T).astype(np.float32), own.colors)
    offsets = offsets_at(mean.vertices, together)
    moved = np.nan_to_num(_mean(offsets))
    assert mean.normals is not None
    mean = replace(mean, vertices=mean.vertices + moved[:, None] * mean.normals.astype(float))
    offsets = offsets_at(mean.vertices, together)
    known = np.isfinite(offsets).sum(axis=1)
    std = np.where(known > 1, _std(offsets), np.nan)
    mean = replace(mean, scalars={SPREAD: std.astype(np.float32), COUNT: known.astype(np.float32)})
    return ScanSpread(mean, offsets_at(sample_surface(mean, SAMPLES).points, together), carrier)


def offsets_at(points: Array, together: Together) -> Array:
    """(m, n) how far each scan lies outside of points (m, 3) [m]; NaN where it has no surface."""
    columns = []
    for T, surface in zip(together.poses, together.surfaces, strict=True):
        found = surface.closest(pose.transform(pose.inverse(T), points))
        usual = robust_std(found.distances)
        shown = ~found.on_border & (np.abs(found.distances) < GROSS * usual + 1e-6)
        columns.append(np.where(shown, -found.distances, np.nan))
    return np.column_stack(columns)


def _mean(offsets: Array) -> Array:
    known = np.isfinite(offsets)
    return np.asarray(np.where(known, offsets, 0).sum(axis=1) / np.maximum(known.sum(axis=1), 1))


def _std(offsets: Array) -> Array:
    known = np.isfinite(offsets)
    squares = np.where(known, (offsets - _mean(offsets)[:, None]) ** 2, 0).sum(axis=1)
    return np.asarray(np.sqrt(squares / np.maximum(known.sum(axis=1) - 1, 1)))
