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
