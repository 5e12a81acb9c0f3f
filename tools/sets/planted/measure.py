"""How far a mesh is from the true object after rigid alignment from all yaws, and the scale that would fit."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from tools.sets.planted.shapes import Array

SAMPLES = 20_000
NEAR = 0.003  # [m] a seen point of the truth is covered by a mesh nearer than this


@dataclass(frozen=True)
class Measured:
    """Distances [m] of the mesh to the object after rigid alignment, its scale (1 = right), share of seen surface."""

    rms: float
    p95: float
    scale: float
    covered: float

    @property
    def numbers(self) -> dict[str, float]:
        return asdict(self)


class Surface:
    """Nearest points of a mesh."""

    def __init__(self, mesh: trimesh.Trimesh) -> None:
        import open3d as o3d

        self._tensor = o3d.core.Tensor.from_numpy
        self._scene: Any = o3d.t.geometry.RaycastingScene()
        self._scene.add_triangles(
            self._tensor(np.asarray(mesh.vertices, np.float32)), self._tensor(np.asarray(mesh.faces, np.uint32))
        )

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """Nearest points and their triangles' normals."""
        answer = self._scene.compute_closest_points(self._tensor(points.astype(np.float32)))
        return answer["points"].numpy().astype(float), answer["primitive_normals"].numpy().astype(float)

    def distance(self, points: Array) -> Array:
        return np.asarray(np.linalg.norm(points - self.nearest(points)[0], axis=1))


def measured(mesh_file: Path, truth: Path) -> Measured:
    """The mesh of a scan beside `truth/object.ply` and the points that were seen of it."""
    mesh: Any = trimesh.load(mesh_file, process=False)
    rng = np.random.default_rng(0)
    points = np.asarray(trimesh.sample.sample_surface(mesh, SAMPLES, seed=0)[0], float)
    return compared(points, Surface(mesh), truth, rng)


def compared(points: Array, mesh: Surface, truth: Path, rng: np.random.Generator) -> Measured:
    true: Any = trimesh.load(truth / "object.ply", process=False)
    surface, seen = Surface(true), np.load(truth / "seen.npz")["points"].astype(float)
    gross = _spread(seen) / _spread(points)
    gross = gross if not 0.8 < gross < 1.25 else 1.0  # a wrong unit: compared in its own size
    few = rng.permutation(len(points))[:1500]
    starts = [start @ np.diag([gross, gross, gross, 1.0]) for start in _starts(points * gross, seen)]
    starts.sort(key=lambda T: _misfit(surface, _moved(T, points[few][:300])))
    found = [_refined(surface, T, points[few], (0.03, 0.015, 0.008)) for T in starts[:4]]
    best = min(found, key=lambda T: _misfit(surface, _moved(T, points[few])))
    best = _refined(surface, best, points, (0.008,))
    freed = _refined(surface, best, points, (0.015, 0.008), free=True)
    d = surface.distance(_moved(best, points))
    # the truth's seen points in the mesh's frame and size
    missed = mesh.distance(_moved(np.linalg.inv(freed), seen)) * _size(freed)
    rms = float(np.sqrt((d**2).mean()))
    # _size is what the mesh has to be multiplied by
    return Measured(rms, float(np.quantile(d, 0.95)), 1 / _size(freed), float((missed < NEAR).mean()))


def _starts(points: Array, seen: Array) -> list[Array]:
    """72 yaws, the plate's axis or the centres on one another."""
    out = []
    for yaw in np.deg2rad(np.arange(0, 360, 5)):
        R = trimesh.transformations.rotation_matrix(yaw, [0, 0, 1])
        on_axis, centred = R.copy(), R.copy()
        centred[:3, 3] = seen.mean(axis=0) - R[:3, :3] @ points.mean(axis=0)
        out += [on_axis, centred]
    return out


def _refined(surface: Surface, T: Array, points: Array, reaches: tuple[float, ...], free: bool = False) -> Array:
    """Point to plane, nearer and nearer; with `free` the scale joins."""
    for reach in reaches:
        for _ in range(12):
            moved = _moved(T, points)
            nearest, normal = surface.nearest(moved)
            use = np.linalg.norm(moved - nearest, axis=1) < reach
            if use.sum() < 50:
                break
            p, n = moved[use], normal[use]
            centre = p.mean(axis=0)
            J = np.hstack([np.cross(p - centre, n), n, ((p - centre) * n).sum(axis=1)[:, None]])[:, : 7 if free else 6]
            x = np.linalg.lstsq(J, ((nearest[use] - p) * n).sum(axis=1), rcond=None)[0]
            angle = float(np.linalg.norm(x[:3]))
            step = trimesh.transformations.rotation_matrix(angle, x[:3] if angle else [0, 0, 1])
            step[:3, :3] *= 1 + (x[6] if free else 0.0)
            step[:3, 3] = x[3:6] + centre - step[:3, :3] @ centre
            T = step @ T
    return T


def _misfit(surface: Surface, points: Array) -> float:
    return float(np.minimum(surface.distance(points), 0.02).mean())


def _moved(T: NDArray[Any], points: NDArray[Any]) -> Array:
    return np.asarray(points @ T[:3, :3].T + T[:3, 3])


def _size(T: Array) -> float:
    return float(np.cbrt(np.linalg.det(T[:3, :3])))


def _spread(points: Array) -> float:
    return float(np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean()))
