"""A trajectory: one pose per time stamp; a frame without a pose holds NaN."""

from dataclasses import dataclass

import numpy as np

from fusion.geometry.pose import Array


@dataclass(frozen=True)
class Trajectory:
    """Poses of a moving camera.

    Attributes:
        timestamps: (n,) [s].
        poses: (n, 4, 4) `T_world_camera`; a rejected frame is all NaN.
    """

    timestamps: Array
    poses: Array

    def __repr__(self) -> str:
        return f"<Trajectory: {len(self)} frames, {int(self.valid.sum())} of them with a pose>"

    def __len__(self) -> int:
        return len(self.timestamps)

    @property
    def valid(self) -> np.ndarray:
        """(n,) bool: frames that have a pose."""
        return np.asarray(np.isfinite(self.poses).all(axis=(1, 2)))

    @property
    def centres(self) -> Array:
        """(n, 3) camera centres [m], NaN where a frame has no pose."""
        return self.poses[:, :3, 3]

    def at(self, timestamps: Array, tolerance: float = 0.02) -> "Trajectory":
        """The poses nearest in time to the given stamps (m,) [s]; NaN where none lies within the tolerance."""
        poses = np.full((len(timestamps), 4, 4), np.nan)
        if len(self):
            order = np.argsort(self.timestamps)
            known = self.timestamps[order]
            right = np.clip(np.searchsorted(known, timestamps), 1, max(len(known) - 1, 1))
            right = np.minimum(right, len(known) - 1)
            left = np.maximum(right - 1, 0)
            nearer = np.abs(known[left] - timestamps) <= np.abs(known[right] - timestamps)
            best = np.where(nearer, left, right)
            close = np.abs(known[best] - timestamps) <= tolerance
            poses[close] = self.poses[order[best[close]]]
        return Trajectory(np.asarray(timestamps, float), poses)


ASSOCIATED = 0.01  # [s] poses nearer in time belong together; evo's default
FEWEST = 3  # centres that fix an alignment


@dataclass(frozen=True)
class TrajectoryError:
    """Absolute pose error: distances of the camera centres after a rigid alignment onto the reference [m]."""

    # rmse, mean, median, std, min, max: over the frames
    rmse: float
    mean: float
    median: float
    std: float
    min: float
    max: float
    frames: int  # that have a pose in both


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
