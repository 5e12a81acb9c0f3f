"""Measures a mesh against the true one with `fusion compare`, and its size once more with code of its own."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tools.sets.judging.command import fusion
from tools.sets.judging.said import content
from tools.sets.planted.measure import Surface

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Compared:
    """From comparison.json: distances mesh to truth [m], its scale, share of what was seen within 5 mm."""

    rms: float
    std: float
    scale: float
    covered: float


def compared(mesh: Path, truth: Path, output: Path, seen: Path, scale: bool = False) -> Compared | None:
    """`fusion compare MESH TRUTH`; None where it refuses or there is no mesh. `scale` is what the MESH is too large."""
    if not mesh.is_file():
        return None
    options = ["--seen", seen, "--overwrite", "--no-report", *(["--scale"] if scale else [])]
    ran = fusion("compare", mesh, truth, "-o", output, *options)
    found = content(output / "comparison.json")
    if ran.status or not found:
        return None
    near, far = found["accuracy"], found["completeness"]
    return Compared(float(near["rms"]), float(near["std"]), 1 / float(found["scale"]), float(far["within"]["0.005"]))


@dataclass(frozen=True)
class Fit:
    """`std` [m] of signed distances after a rigid fit; `scale` by a free one, 1.01 is too large."""

    std: float
    scale: float


def own_fit(mesh_file: Path, truth_file: Path, T_truth_mesh: Array, reach: float = 0.01) -> Fit:
    """Point to plane over the mesh's area, from where the poses say that it stands; `reach` [m]: beyond, no pull."""
    mesh: Any = trimesh.load(mesh_file, process=False)
    true: Any = trimesh.load(truth_file, process=False)
    points = np.asarray(trimesh.sample.sample_surface(mesh, 30_000, seed=0)[0], float)
    surface, size, std = Surface(true), 1.0, float("nan")
    moved = points @ T_truth_mesh[:3, :3].T + T_truth_mesh[:3, 3]
    for free in (False, True):
        for step in range(40):
            wide = 3 * reach if step < 15 and not free else reach
            nearest, normal = surface.nearest(moved)
            use = np.linalg.norm(moved - nearest, axis=1) < wide
            if use.sum() < 100:
                return Fit(float("nan"), float("nan"))
            p, n = moved[use], normal[use]
            centre = p.mean(axis=0)
            J = np.hstack([np.cross(p - centre, n), n, ((p - centre) * n).sum(axis=1)[:, None]])[:, : 7 if free else 6]
            x = np.zeros(7)
            x[: J.shape[1]] = np.linalg.lstsq(J, ((nearest[use] - p) * n).sum(axis=1), rcond=None)[0]
            turn = Rotation.from_rotvec(x[:3]).as_matrix() * (1 + x[6])
            moved, size = (moved - centre) @ turn.T + centre + x[3:6], size * (1 + x[6])
            if step > 20 and np.abs(x).max() < 1e-7:
                break
        if not free:
            std = float(np.std(signed(surface, moved)))
    return Fit(std, float(1 / size))


def signed(surface: Surface, points: Array) -> Array:
    """Distances [m], positive outside."""
    nearest, normal = surface.nearest(points)
    away = points - nearest
    return np.asarray(np.linalg.norm(away, axis=1) * np.sign((away * normal).sum(axis=1)))


def offset(mesh_file: Path, truth_file: Path) -> float:
    """Median signed distance [m] of a mesh that stands where it should; below zero it is too thin."""
    mesh: Any = trimesh.load(mesh_file, process=False)
    true: Any = trimesh.load(truth_file, process=False)
    points = np.asarray(trimesh.sample.sample_surface(mesh, 30_000, seed=0)[0], float)
    return float(np.median(signed(Surface(true), points)))


def angle_errors(table: dict[str, Any], true: Array) -> Array:
    """(n,) [deg] of turntable.json's angles after the best constant, NaN where a frame is rejected.

    True angles [rad] are right-handed about the axis that points up, as those of the file.
    """
    told = np.array([np.nan if x is None else x for x in table.get("angles_rad", [])], float)
    if len(told) != len(true):
        return np.full(len(true), np.nan)
    error = np.rad2deg(told - true)
    return np.asarray(error - np.nanmedian(error) if np.isfinite(error).any() else error)
