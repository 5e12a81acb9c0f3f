"""How far a mesh is from the true one, where the trajectory's rigid motion puts it."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from tools.sets.loop_scenes.place.prints import Array
from tools.sets.planted.measure import Surface

SAMPLES = 100_000


@dataclass(frozen=True)
class Off:
    """Distances [m] of points of a mesh, even over its area, to the true one; share of them beyond what is asked."""

    median: float
    p95: float
    beyond: float


def off(mesh_file: Path, truth_file: Path, T_truth_mesh: Array, far: float, middle: Array | None, reach: float) -> Off:
    """Of the whole mesh, or where `middle` (3,) is given of what lies within `reach` [m] of it; `far` [m] is beyond."""
    nothing = Off(float("nan"), float("nan"), float("nan"))
    if not mesh_file.is_file():
        return nothing
    mesh: Any = trimesh.load(mesh_file, process=False)
    true: Any = trimesh.load(truth_file, process=False)
    if not len(getattr(mesh, "faces", ())):
        return nothing
    points = np.asarray(trimesh.sample.sample_surface(mesh, SAMPLES, seed=0)[0], float)
    points = points @ T_truth_mesh[:3, :3].T + T_truth_mesh[:3, 3]
    if middle is not None:
        points = points[np.linalg.norm(points - middle, axis=1) < reach]
    if not len(points):
        return nothing
    d = Surface(true).distance(points)
    return Off(float(np.median(d)), float(np.quantile(d, 0.95)), float((d > far).mean()))
