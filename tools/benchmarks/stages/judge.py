"""Speed is never bought with wrongness: surfaces against the exact shape, poses against the true ones."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tools.benchmarks.stages import knot, room
from tools.benchmarks.stages.contest import OURS, Score
from tools.benchmarks.stages.workloads import WORKLOADS

SAMPLE = 200_000  # vertices looked at
POINTS, NOISE = 1_000_000, 0.001  # of the distances' query; standard deviation [m]


def surface_errors(workload: str, arrays: Path) -> dict[str, float]:
    """Median, mean and 95th percentile of the distance from vertices to the true surface [mm]."""
    vertices = np.load(arrays)["vertices"].astype(float)
    if len(vertices) > SAMPLE:
        vertices = vertices[np.random.default_rng(0).choice(len(vertices), SAMPLE, replace=False)]
    error = room.distance(vertices) if workload == "room" else _to_knot(vertices)
    return {
        "median": float(np.median(error) * 1e3),
        "mean": float(error.mean() * 1e3),
        "95 %": float(np.quantile(error, 0.95) * 1e3),
    }


def _to_knot(points: NDArray[np.float64]) -> NDArray[np.float64]:
    from fusion.mesh.comparison.distances import signed_distances
    from fusion.mesh.mesh import Mesh

    return np.abs(signed_distances(points, Mesh(*knot.Knot().mesh(2000, 300))))


def query(cache: Path) -> Path:
    """The file of the distances' work: a million points around the knot of 200 000 triangles."""
    path = cache / "points-1.npz"
    if not path.exists():
        vertices, faces = knot.Knot().mesh()
        rng = np.random.default_rng(0)
        corners = vertices[faces[rng.integers(0, len(faces), POINTS)]]
        on = np.einsum("nij,ni->nj", corners, rng.dirichlet((1, 1, 1), POINTS))
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        points = on + normal * rng.normal(0, NOISE, (POINTS, 1))
        np.savez(path, vertices=vertices, faces=faces, points=points, name="points", voxel=0, truncation=0, far=0)
    return path


def misses(stage: str, workload: str, peer: Score) -> str:
    """Why a peer's result does not count as the stage's work, "" where it does.

    The limits leave room for the peers' habits (half a pixel, coarser stops), not for failures: twice a voxel in
    depth, nine tenths of the pixels; ten times what the best odometry reaches elsewhere (0.15 mm, 0.02 degrees).
    """
    depth, seen = peer.value("depth_error"), peer.value("seen")
    if stage == "raycast" and depth is not None and seen is not None:
        if not depth < 2 * WORKLOADS[workload].voxel:
            return f"the depth seen is {depth * 1e3:.1f} mm off"
        if seen < 0.9:
            return f"{seen:.0%} of the pixels are seen"
    if stage == "align":
        shift, turn = peer.value("shift_mm") or 0.0, peer.value("turn_deg") or 0.0
        if not (shift < 1.5 and turn < 0.2):
            return f"{shift:.2f} mm and {turn:.2f} degrees off"
    if stage == "extract" and peer.arrays:
        error = surface_errors(workload, peer.arrays)["median"]
        if not error < 2 * WORKLOADS[workload].voxel * 1e3:
            return f"the surface is {error:.1f} mm off"
    return ""


def disagreements(stage: str, workload: str, scores: list[Score]) -> list[str]:
    """Sentences about results of fusion that differ from what the work asks for."""
    ours = next(s for s in scores if s.contestant.name == OURS)
    peers = [s for s in scores if s is not ours and s.answers]
    found = []
    if stage in ("integrate", "raycast", "extract", "error", "memory"):
        half = WORKLOADS[workload].voxel / 2 * 1e3
        error = ours.value("depth_error")
        if error is None or not error * 1e3 < half:
            found.append(f"the depth seen is {error} m off: more than half a voxel")
        if ours.arrays and not surface_errors(workload, ours.arrays)["median"] < half:
            found.append("the surface is more than half a voxel off")
    if stage == "align":
        for key in ("shift_mm", "turn_deg"):
            best = min((s.value(key) or 0.0 for s in peers), default=np.inf)
            if not (ours.value(key) or 0.0) <= best + 1e-3:
                found.append(f"{key} {ours.value(key):.3f} is above the best peer's {best:.3f}")
    if stage == "update" and ours.value("lost"):
        found.append(f"{ours.value('lost'):.0f} frames were lost")
    if stage == "distances":
        means = [s.value("mean_um") or 0.0 for s in [ours, *peers]]
        if np.ptp(means) > 0.01:  # [um] single precision
            found.append(f"mean distances differ: {means}")
    return found
