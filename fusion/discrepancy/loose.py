"""Loose: errors that no law follows, each with the size that the recordings show."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Loose:
    """Sizes of what differs without a law; as they stand here where the recordings contradict nothing that was said.

    Attributes:
        scatter: standard deviation [native unit] of an error that each tile has for itself.
        drift: the same of a smooth field of the image that each recording has for itself.
        uneven: variance of both in recording 0, 1, ... over the usual one; empty where they are even.
        pose: by how much poses are worse than stated: a factor on their standard deviations.
        shape: standard deviation [m] of the shape of targets of which nobody said how flat they are.
    """

    scatter: float = 0.0
    drift: float = 0.0
    uneven: tuple[float, ...] = ()
    pose: float = 1.0
    shape: float = 0.0

    def with_more(self, found: "Loose") -> "Loose":
        """With what was found beside it: sizes of independent errors add up as squares."""
        return Loose(
            float(np.hypot(self.scatter, found.scatter)),
            float(np.hypot(self.drift, found.drift)),
            found.uneven or self.uneven,
            self.pose * found.pose,
            float(np.hypot(self.shape, found.shape)),
        )
