"""How far a trajectory is from a reference, as `evo_ape tum REFERENCE TRAJECTORY --align` measures it."""

from dataclasses import dataclass

import numpy as np

from fusion.geometry.pose import Array
from fusion.geometry.trajectory import Trajectory

ASSOCIATED = 0.01  # [s] poses nearer in time belong together; evo's default
FEWEST = 3  # centres that fix an alignment


@dataclass(frozen=True)
class TrajectoryError:
    """Absolute pose error: distances of the camera centres after a rigid alignment onto the reference [m].

    Attributes:
        rmse, mean, median, std, min, max: over the frames.
        frames: that have a pose in both.
    """

    rmse: float
    mean: float
    median: float
    std: float
    min: float
    max: float
    frames: int


def trajectory_error(measured: Trajectory, reference: Trajectory) -> TrajectoryError | None:
    """The error of a trajectory against a reference; None where fewer than three poses belong together.

    Each pose is compared with the reference's pose nearest in time. The alignment turns and shifts, without scale.
    """
    right = reference.at(measured.timestamps, ASSOCIATED)
    both = measured.valid & right.valid
    if both.sum() < FEWEST:
        return None
    ours, theirs = measured.centres[both], right.centres[both]
    off = np.linalg.norm(_aligned(ours, theirs) - theirs, axis=1)
    return TrajectoryError(
        rmse=float(np.sqrt(np.mean(off**2))),
        mean=float(off.mean()),
        median=float(np.median(off)),
        std=float(off.std()),
        min=float(off.min()),
        max=float(off.max()),
        frames=int(both.sum()),
    )


def _aligned(points: Array, targets: Array) -> Array:
    """Points (n, 3) turned and shifted onto their targets (n, 3) by least squares (Kabsch; Umeyama without scale)."""
    here, there = points.mean(axis=0), targets.mean(axis=0)
    u, _, vt = np.linalg.svd((targets - there).T @ (points - here))
    handed = np.diag([1.0, 1.0, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    return np.asarray((points - here) @ (u @ handed @ vt).T + there)
