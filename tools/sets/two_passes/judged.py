"""Scans both passes, merges the results as a user would, and measures against the truth with code of its own."""

import json
import shutil
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tools.sets.judging.command import Ran, fusion
from tools.sets.judging.said import content
from tools.sets.planted.measure import Surface

Array = NDArray[np.float64]
ALIGNED = 0.003  # [m] rms over the object's surface by which an aligned pass may miss the true transform
RATIO = 1.1  # of the rms with the true transform
WITHIN = 0.003  # [m] of the mesh: a point of the truth is there
WORDS = {"different": "not show one object", "symmetric": "symmetric", "overlap": "too little surface"}  # of a refusal
SAMPLES = 20_000
DIRECTIONS = 60  # from which a point of the surface may be seen: what lies in other parts is no surface


@dataclass(frozen=True)
class Judged:
    """A pair; lengths in metres, NaN where there is no number.

    Attributes:
        miss: rms over the surface between the transform found and the true one.
        rms, rms_true: mesh to truth, of the merge and of that with the true transform.
        covered, covered_true: share of the outer surface of the truth within WITHIN of the mesh.
        said: last line of a refusal, or the verdict.
    """

    name: str
    what: str
    refused: str
    status: int
    said: str
    miss: float
    rms: float
    rms_true: float
    covered: float
    covered_true: float
    seconds: float

    @property
    def right(self) -> bool:
        """Aligned and as good as with the true transform, or refused for the right reason."""
        if self.refused:
            return self.status == 1 and WORDS[self.refused] in self.said
        return self.status == 0 and self.miss < ALIGNED and self.rms <= RATIO * self.rms_true


def judged(folder: Path) -> Judged:
    """A pair's folder, made before; scans that are there are taken."""
    truth = json.loads((folder / "truth" / "truth.json").read_text(encoding="utf-8"))
    what = f"{truth['shape']}, {truth['camera']}"
    scans = [folder / "scan_1", folder / "scan_2"]
    for number, scan in enumerate(scans, 1):
        if not (scan / "settings.json").is_file():
            shutil.rmtree(scan, ignore_errors=True)
            ran = fusion("turntable", folder / f"pass_{number}", "-o", scan, "--no-report")
            if ran.status:
                no = float("nan")
                said = truth["refused"], ran.status, ran.last
                return Judged(folder.name, what, *said, no, no, no, no, no, ran.seconds)
    T_true = true_transform(folder)
    _write_transforms(folder / "truth" / "transforms.json", T_true)
    ran = fusion("merge", *scans, "-o", folder / "merged", "--overwrite", "--no-report")
    found = content(folder / "merged" / "merge.json") if ran.status == 0 else {}
    outer = outer_points(folder)
    rms, covered = measured(folder, "merged", outer) if found else (float("nan"), float("nan"))
    rms_true = covered_true = float("nan")
    if not truth["refused"]:
        known = ["--transforms", folder / "truth" / "transforms.json", "--overwrite", "--no-report"]
        if fusion("merge", *scans, "-o", folder / "true", *known).status == 0:
            rms_true, covered_true = measured(folder, "true", outer)
    miss = float("nan")
    if found:
        T = np.array(found["passes"][1]["T_merged_pass"], float)
        there = outer @ scan_of(folder, 2)[:3, :3].T + scan_of(folder, 2)[:3, 3]
        off = there @ (T - T_true)[:3, :3].T + (T - T_true)[:3, 3]
        miss = float(np.sqrt(np.mean(np.sum(off**2, axis=1))))
    numbers = (miss, rms, rms_true, covered, covered_true, ran.seconds)
    return Judged(folder.name, what, truth["refused"], ran.status, _said(ran, found), *numbers)


def _said(ran: Ran, found: dict[str, Any]) -> str:
    return ran.last if ran.status else str(found.get("verdict", ""))


def true_transform(folder: Path) -> Array:
    """(4, 4) from the second scan's frame to the first's, by the true poses of both cameras."""
    return np.asarray(scan_of(folder, 1) @ np.linalg.inv(scan_of(folder, 2)))


def scan_of(folder: Path, number: int) -> Array:
    """`T_scan_object` (4, 4): where a scan has put the true object, mean over its frames."""
    true = np.loadtxt(folder / "truth" / f"poses_{number}.txt")
    told = np.loadtxt(folder / f"scan_{number}" / "trajectory.txt")
    at = np.abs(true[:, 0] - told[:, :1]).argmin(axis=1)
    own, other = _poses(told), _poses(true[at])
    between = own @ np.linalg.inv(other)
    T = np.eye(4)
    T[:3, :3] = Rotation.from_matrix(between[:, :3, :3]).mean().as_matrix()
    # the turn that is left over is about the object, not about the origin of its frame
    middle = np.asarray(trimesh.load(folder / "truth" / "object.ply", process=False).bounds, float).mean(axis=0)
    T[:3, 3] = (between[:, :3, :3] @ middle + between[:, :3, 3]).mean(axis=0) - T[:3, :3] @ middle
    return T


def _poses(rows: Array) -> Array:
    T = np.tile(np.eye(4), (len(rows), 1, 1))
    T[:, :3, :3] = Rotation.from_quat(rows[:, 4:8]).as_matrix()
    T[:, :3, 3] = rows[:, 1:4]
    return T


def _write_transforms(file: Path, T: Array) -> None:
    rows = [{"T_merged_pass": np.eye(4).tolist()}, {"T_merged_pass": T.tolist()}]
    file.write_text(json.dumps({"passes": rows}, indent=1), encoding="utf-8")


def outer_points(folder: Path) -> Array:
    """Points (n, 3) of the true surface that can be seen from somewhere outside."""
    import open3d as o3d

    mesh: Any = trimesh.load(folder / "truth" / "object.ply", process=False)
    points, face = trimesh.sample.sample_surface(mesh, SAMPLES, seed=0)
    normals = np.asarray(mesh.face_normals[face], float)
    scene: Any = o3d.t.geometry.RaycastingScene()
    tensor = o3d.core.Tensor.from_numpy
    scene.add_triangles(tensor(np.asarray(mesh.vertices, np.float32)), tensor(np.asarray(mesh.faces, np.uint32)))
    ways = np.random.default_rng(0).standard_normal((DIRECTIONS, 3))
    seen = np.zeros(len(points), bool)
    for way in ways / np.linalg.norm(ways, axis=1, keepdims=True):
        rays = np.concatenate([points + 1e-4 * normals, np.broadcast_to(way, points.shape)], axis=1).astype(np.float32)
        seen |= ~np.isfinite(scene.cast_rays(tensor(rays))["t_hit"].numpy()) & (normals @ way > 0.1)
    return np.asarray(points, float)[seen]


def measured(folder: Path, name: str, outer: Array) -> tuple[float, float]:
    """Rms of the mesh to the truth after a rigid fit [m], and the share of the outer surface that it covers."""
    mesh: Any = trimesh.load(folder / name / "mesh.ply", process=False)
    true: Any = trimesh.load(folder / "truth" / "object.ply", process=False)
    points = np.asarray(trimesh.sample.sample_surface(mesh, SAMPLES, seed=0)[0], float)
    T = np.linalg.inv(scan_of(folder, 1))  # the merge stands in the first scan's frame
    surface, moved = Surface(true), points @ T[:3, :3].T + T[:3, 3]
    whole = T
    for _ in range(30):
        nearest, normal = surface.nearest(moved)
        off = ((nearest - moved) * normal).sum(axis=1)
        use = np.abs(off) < 0.01
        J = np.hstack([np.cross(moved[use], normal[use]), normal[use]])
        x = np.linalg.lstsq(J, off[use], rcond=None)[0]
        step = np.eye(4)
        step[:3, :3], step[:3, 3] = Rotation.from_rotvec(x[:3]).as_matrix(), x[3:]
        moved, whole = moved @ step[:3, :3].T + step[:3, 3], step @ whole
        if np.abs(x).max() < 1e-7:
            break
    rms = float(np.sqrt(np.mean(np.sum((moved - surface.nearest(moved)[0]) ** 2, axis=1))))
    back = np.linalg.inv(whole)
    near = Surface(mesh).distance(outer @ back[:3, :3].T + back[:3, 3])
    return rms, float(np.mean(near < WITHIN))


HEAD = f"{'pair':<9}{'right':<7}{'miss mm':>8}{'rms mm':>8}{'true':>6}{'seen %':>8}{'true':>7}{'s':>6}  what; said"


def line(one: Judged) -> str:
    """One pair."""
    return (
        f"{one.name:<9}{'yes' if one.right else 'NO':<7}{1e3 * one.miss:>8.2f}{1e3 * one.rms:>8.2f}"
        f"{1e3 * one.rms_true:>6.2f}{100 * one.covered:>8.1f}{100 * one.covered_true:>7.1f}{one.seconds:>6.0f}"
        f"  {one.what}; {one.said[:150]}"
    )


def summary(pairs: Sequence[Judged]) -> str:
    """How many were aligned, how good, how much was seen."""
    done = [one for one in pairs if not one.refused]
    rows = []
    if done:
        aligned = [one for one in done if one.status == 0 and one.miss < ALIGNED]
        silent = [one.name for one in done if one.status == 0 and not one.miss < ALIGNED]
        ratio = [one.rms / one.rms_true for one in aligned]
        rows.append(f"aligned: {len(aligned)} of {len(done)}; wrong and not said: {' '.join(silent) or 'none'}")
        if aligned:
            rows.append(f"rms over that with the true transform: median {np.median(ratio):.3f}, most {max(ratio):.3f}")
            rows.append(f"seen of the whole surface: least {100 * min(one.covered for one in aligned):.1f} %")
    refused = [one for one in pairs if one.refused]
    if refused:
        rows.append(f"refused for the right reason: {sum(one.right for one in refused)} of {len(refused)}")
    return "\n".join(rows)


def row(one: Judged) -> dict[str, Any]:
    """For JSON; NaN becomes null."""
    told = asdict(one) | {"right": one.right}
    return {k: None if isinstance(x, float) and not np.isfinite(x) else x for k, x in told.items()}
