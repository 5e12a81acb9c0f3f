"""Shapes: how targets leave their meshes, each in its own way or all alike."""

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference.covariance import BENDS_M, bend, bending, bow
from fusion.discrepancy.inference.loose import Loose
from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.observe.patch import Patch
from fusion.discrepancy.observe.scene.stage import KnownScene
from fusion.sensor.laws.surface import rigid_motions, towards

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

USUAL_SCALE = 0.01  # by which a mesh whose size nobody checked may be wrong: guess


def shape_covariance(observations: Observations) -> Matrix:
    """(n, n) covariance in native units of targets that are not quite their mesh: one shape in all its recordings."""
    loose, known, total = observations.loose, [], np.zeros((len(observations.residual),) * 2)
    for rows, patch in observations.rows():
        said = patch.block.stage.mesh_sigma_m
        if loose.bent if said is None else said:
            known.append((rows, patch.block.stage, *surface(patch)))
    for rows, stage, points, lever in known:
        for others, other, other_points, other_lever in known:
            alike = _alike(stage, other, points, other_points, loose)
            if np.any(alike):
                total[rows, others] += alike * np.outer(lever, other_lever)
    return total


def mesh_columns(observations: Observations) -> Matrix:
    """(n, 4) all meshes larger by `USUAL_SCALE` about the middle of what is seen, and set off as that would along axes.

    (n, 0) where a simulation stands for the mesh.
    In native units. A mesh of another size about another place is the sum of both.
    """
    n = len(observations.residual)
    if any(patch.block.stage.caster is None for patch in observations.patches):
        return np.zeros((n, 0))
    seen = [(rows, patch, surface(patch)[0]) for rows, patch in observations.rows()]
    every = np.concatenate([points for _, _, points in seen])
    middle, off = every.mean(axis=0), USUAL_SCALE * float(np.linalg.norm(every - every.mean(axis=0), axis=1).mean())
    out = np.zeros((n, 4))
    for rows, patch, _ in seen:
        T = patch.block.T_world_camera
        # along the axes of the camera, then of the world
        along = np.array([patch.tiles.mean(one * patch.native) for one in rigid_motions(patch.depth, patch.view)[3:]])
        shifts = list(T[:3, :3] @ along)
        # larger about the camera, and the middle put back
        larger = patch.tiles.mean(patch.depth * patch.native) + (T[:3, 3] - middle) @ shifts
        out[rows] = np.column_stack([USUAL_SCALE * larger, *(off * shift for shift in shifts)])
    return out


def mesh_off(observations: Observations, pulled: Vector) -> tuple[float, float]:
    """Share by which all meshes are too small, and root mean square [m] of how far surfaces are off for it and for
    where they stand, as the tiles tell it; zeros where nothing says that they are.

    Args:
        pulled: (n,) residual divided by its covariance.
    """
    if not observations.loose.mesh:
        return 0.0, 0.0
    columns = observations.loose.mesh * mesh_columns(observations)
    weights = columns.T @ pulled
    levers = np.concatenate([surface(patch)[1] for patch in observations.patches])
    off = float(np.sqrt(np.mean(np.square(columns @ weights / levers))))
    return float(USUAL_SCALE * observations.loose.mesh * weights[0]), off


def bent_m(observations: Observations, pulled: Vector) -> float:
    """Root mean square [m] of what targets leave their mesh by where no tolerance is stated, as the tiles tell it.

    Args:
        pulled: (n,) residual divided by its covariance.
    """
    if not observations.loose.bent:
        return 0.0
    likeliest = shape_covariance(observations) @ pulled
    unsaid = [
        likeliest[rows] / surface(patch)[1]
        for rows, patch in observations.rows()
        if patch.block.stage.mesh_sigma_m is None
    ]
    return float(np.sqrt(np.mean(np.square(np.concatenate(unsaid)))))


def _alike(stage: KnownScene, other: KnownScene, points: Matrix, others: Matrix, loose: Loose) -> Matrix | float:
    """Covariance (n, m) [m^2] of the shapes of two targets at points (n, 3) and (m, 3)."""
    own, said, other_said = stage.shape == other.shape, stage.mesh_sigma_m, other.mesh_sigma_m
    if said is not None and other_said is not None:
        return bow(points, others, 1.0) * said * other_said if own else 0.0
    if said is not None or other_said is not None:
        return 0.0
    sizes = np.square(loose.room) + (np.square(loose.shape) if own else 0.0)
    return sum((v * bend(points, others, length) for v, length in zip(sizes, BENDS_M, strict=True) if v), 0.0)


def shape_columns(observations: Observations) -> list[Matrix]:
    """(n, k) columns of which the products sum up to the covariance of shapes that nobody stated, of unit size [m].

    For each length of `BENDS_M`; each mesh has a shape of its own.
    """
    return [_bending(observations, length, common=False) for length in BENDS_M]


def room_columns(observations: Observations) -> list[Matrix]:
    """(n, k) the same of one shape for all of these meshes, by place in the world; none where all are one mesh."""
    unsaid = {p.block.stage.shape for p in observations.patches if p.block.stage.mesh_sigma_m is None}
    none = np.zeros((len(observations.residual), 0))
    return [_bending(observations, length, common=True) if len(unsaid) > 1 else none for length in BENDS_M]


def _bending(observations: Observations, length_m: float, common: bool) -> Matrix:
    n = len(observations.residual)
    shapes: dict[str, list[tuple[slice, Matrix, Vector]]] = {}
    for rows, patch in observations.rows():
        if patch.block.stage.mesh_sigma_m is None:
            shapes.setdefault("" if common else patch.block.stage.shape, []).append((rows, *surface(patch)))
    blocks = [np.zeros((n, 0))]
    for parts in shapes.values():
        points, lever = np.concatenate([part[1] for part in parts]), np.concatenate([part[2] for part in parts])
        own = lever[:, None] * bending(points, length_m)
        block = np.zeros((n, own.shape[1]))
        block[np.concatenate([np.arange(rows.start, rows.stop) for rows, _, _ in parts])] = own
        blocks.append(block)
    return np.concatenate(blocks, axis=1)


def surface(patch: Patch) -> tuple[Matrix, Vector]:
    """(n, 3) points of the tiles in the world [m], and (n,) native units per metre along the surface's normal."""
    seen = patch.view.camera.points(patch.depth)
    at = np.column_stack([patch.tiles.mean(seen[..., axis]) for axis in range(3)])
    T = patch.block.T_world_camera
    return at @ T[:3, :3].T + T[:3, 3], patch.tiles.mean(patch.native / towards(patch.view))
