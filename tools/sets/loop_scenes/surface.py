"""How far a mesh is from the true one where the trajectory's rigid motion puts it, and whether its sigma says so."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from tools.sets.loop_scenes.place.prints import Array
from tools.sets.planted.measure import Surface

SAMPLES = 100_000
NINETY = 1.645  # standard deviations
LAID = 0.02  # [m] points farther off have no say in how the mesh is laid on the truth


@dataclass(frozen=True)
class Off:
    """Distances [m] of points of a mesh, even over its area, to the true one.

    Attributes:
        beyond: share of them beyond what is asked.
        within: share within the mesh's own 90 % interval, once it is laid on the truth; NaN where it has no sigma.
    """

    median: float
    p95: float
    beyond: float
    within: float = float("nan")


def off(mesh_file: Path, truth_file: Path, T_truth_mesh: Array, far: float, middle: Array | None, reach: float) -> Off:
    """Of the whole mesh, or where `middle` (3,) is given of what lies within `reach` [m] of it; `far` [m] is beyond."""
    nothing = Off(float("nan"), float("nan"), float("nan"))
    if not mesh_file.is_file():
        return nothing
    mesh: Any = trimesh.load(mesh_file, process=False)
    true: Any = trimesh.load(truth_file, process=False)
    if not len(getattr(mesh, "faces", ())):
        return nothing
    points, faces = trimesh.sample.sample_surface(mesh, SAMPLES, seed=0)
    sigma = _sigma(mesh)[mesh.faces[faces]].mean(axis=1)
    points = np.asarray(points, float) @ T_truth_mesh[:3, :3].T + T_truth_mesh[:3, 3]
    if middle is not None:
        near = np.linalg.norm(points - middle, axis=1) < reach
        points, sigma = points[near], sigma[near]
    if not len(points):
        return nothing
    surface = Surface(true)
    d = surface.distance(points)
    within = float(np.mean(_laid(points, surface) < NINETY * sigma)) if np.isfinite(sigma).any() else float("nan")
    return Off(float(np.median(d)), float(np.quantile(d, 0.95)), float((d > far).mean()), within)


def _sigma(mesh: Any) -> Array:
    """(n,) of the vertices, NaN where the file has none."""
    rows = mesh.metadata.get("_ply_raw", {}).get("vertex", {}).get("data")
    names = () if rows is None else rows.dtype.names
    return np.asarray(rows["scalar_sigma"], float) if "scalar_sigma" in names else np.full(len(mesh.vertices), np.nan)


def _laid(points: Array, surface: Surface) -> Array:
    """Distances (n,) [m] after the rigid motion that brings points (n, 3) closest to a surface."""
    for _ in range(15):
        nearest, normal = surface.nearest(points)
        off = ((nearest - points) * normal).sum(axis=1)
        use = np.abs(off) < LAID
        x = np.linalg.lstsq(np.hstack([np.cross(points[use], normal[use]), normal[use]]), off[use], rcond=None)[0]
        points = points @ Rotation.from_rotvec(x[:3]).as_matrix().T + x[3:]
    return np.asarray(surface.distance(points))
