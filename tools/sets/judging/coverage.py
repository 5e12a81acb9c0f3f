"""Whether the standard deviations that a mesh carries are right: its true error beside them, after a rigid fit."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tools.sets.judging.measured import signed
from tools.sets.planted.measure import Surface

Array = NDArray[np.float64]
NINETY, ONE, FAR = 1.645, 1.0, 3.0  # standard deviations: 90 % and 68 % of a normal error, and what is hardly one
REACH = 0.008  # [m] a vertex farther from the truth has no say in the fit


@dataclass(frozen=True)
class Coverage:
    """Shares of the surface, and lengths in metres; NaN where there is no mesh.

    Attributes:
        ninety, one: share of the area whose true error is within 1.645 and 1 sigma.
        far: share of the area beyond 3 sigma.
        rms: of the true error, over the area; `claimed`: of sigma.
        order: rank correlation of the error's size with sigma: does it know where it is wrong?
    """

    ninety: float = np.nan
    one: float = np.nan
    far: float = np.nan
    rms: float = np.nan
    claimed: float = np.nan
    order: float = np.nan


def coverage(mesh_file: Path, truth_file: Path, T_truth_mesh: Array) -> Coverage:
    """Of a mesh with the vertex property `scalar_sigma` [m]; it stands about where the pose (4, 4) says."""
    mesh: Any = trimesh.load(mesh_file, process=False)
    true: Any = trimesh.load(truth_file, process=False)
    sigma = np.asarray(mesh.metadata["_ply_raw"]["vertex"]["data"]["scalar_sigma"], float).ravel()
    surface, points = Surface(true), np.asarray(mesh.vertices, float)
    area = np.zeros(len(points))
    np.add.at(area, np.asarray(mesh.faces), np.repeat(mesh.area_faces[:, None] / 3, 3, axis=1))
    T = fitted(surface, points, T_truth_mesh)
    error = np.abs(signed(surface, points @ T[:3, :3].T + T[:3, 3]))
    known = np.isfinite(sigma)

    def share(which: NDArray[np.bool_]) -> float:
        return float(area[which & known].sum() / area.sum())

    def rms(x: Array) -> float:
        return float(np.sqrt(np.average(x[known] ** 2, weights=area[known])))

    order = _ranks(error[known]) @ _ranks(sigma[known])
    within = (share(error <= NINETY * sigma), share(error <= ONE * sigma), share(error > FAR * sigma))
    return Coverage(*within, rms(error), rms(sigma), float(order))


def fitted(surface: Surface, points: Array, T: Array) -> Array:
    """(4, 4) point to plane, nothing but turned and moved."""
    some = points[np.unique(np.linspace(0, len(points) - 1, 30_000).astype(int))]
    for _ in range(40):
        moved = some @ T[:3, :3].T + T[:3, 3]
        nearest, normal = surface.nearest(moved)
        use = np.linalg.norm(moved - nearest, axis=1) < REACH
        if use.sum() < 100:
            break
        p, n = moved[use], normal[use]
        centre = p.mean(axis=0)
        J = np.hstack([np.cross(p - centre, n), n])
        x = np.linalg.lstsq(J, ((nearest[use] - p) * n).sum(axis=1), rcond=None)[0]
        step = np.eye(4)
        step[:3, :3] = Rotation.from_rotvec(x[:3]).as_matrix()
        step[:3, 3] = centre + x[3:] - step[:3, :3] @ centre
        T = step @ T
        if np.abs(x).max() < 1e-8:
            break
    return np.asarray(T)


def _ranks(x: Array) -> Array:
    """Ranks about their mean, at length 1."""
    ranks = np.argsort(np.argsort(x, kind="stable"), kind="stable").astype(float)
    ranks -= ranks.mean()
    return np.asarray(ranks / max(float(np.linalg.norm(ranks)), 1e-12))
