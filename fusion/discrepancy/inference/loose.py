"""Loose: errors that no law follows, each with the size that the recordings show."""

from dataclasses import dataclass

import numpy as np

from fusion.discrepancy.inference.covariance import BENDS_M

NONE = (0.0,) * len(BENDS_M)


@dataclass(frozen=True)
class Loose:
    """Sizes of what differs without a law; as they stand here where the recordings contradict nothing that was said."""

    scatter: float = 0.0  # standard deviation [native unit] of an error that each tile has for itself
    drift: float = 0.0  # the same of a smooth field of the image that each recording has for itself
    # variance of both in recording 0, 1, ... over the usual one; empty where they are even.
    uneven: tuple[float, ...] = ()
    pose: float = 1.0  # by how much poses are worse than stated: a factor on their standard deviations
    # standard deviations [m] of the shape of targets of which nobody said how flat they are, of each its own: one for
    # every length of `BENDS_M`
    shape: tuple[float, ...] = NONE
    # the same of one shape that all of these have in common, by place in the world: the same walls are meant
    room: tuple[float, ...] = NONE
    mesh: float = 0.0  # by how much all meshes are larger or smaller and set off, over what is usual
    camera: float = 0.0  # by how much the camera file is wrong, over what is usual
    frames: float = 0.0  # by how much poses of a moving camera are off in each view for itself, over what was stated

    @property
    def poses(self) -> float:
        """By how much poses are worse than stated, of recordings and of each view for itself."""
        return float(np.hypot(self.pose, self.frames))

    @property
    def bent(self) -> float:
        """Standard deviation [m] of the shape of a target, of both kinds."""
        return float(np.linalg.norm([*self.shape, *self.room]))

    def with_more(self, found: "Loose") -> "Loose":
        """With what was found beside it: sizes of independent errors add up as squares."""
        return Loose(
            float(np.hypot(self.scatter, found.scatter)),
            float(np.hypot(self.drift, found.drift)),
            found.uneven or self.uneven,
            self.pose * found.pose,
            tuple(np.hypot(self.shape, found.shape).tolist()),
            tuple(np.hypot(self.room, found.room).tolist()),
            float(np.hypot(self.mesh, found.mesh)),
            float(np.hypot(self.camera, found.camera)),
            float(np.hypot(self.frames, found.frames)),
        )
