"""WorkingRange: between which depths a sensor gives values at all."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.errors import SensorError
from fusion.sensor.view import Image


@dataclass(frozen=True)
class WorkingRange:
    """What lies nearer or farther has no value, whatever it looks like.

    It says what a sensor gives, not what can be relied on: a value that is there counts by its noise alone.

    Raises:
        SensorError: the limits are not in order.
    """

    # nearest, farthest: planar z [m]; 0 and infinity where there is no such limit
    nearest: float = 0.0
    farthest: float = np.inf
    source: str = ""  # where they come from

    def __post_init__(self) -> None:
        if not 0 <= self.nearest < self.farthest:
            found = f"{self.nearest:g} to {self.farthest:g} m"
            raise SensorError("a working range cannot be used", found=found, expected="0 or more, nearest first")

    def __str__(self) -> str:
        if self.farthest == np.inf:
            return f"{self.nearest:g} m on"
        return f"{self.nearest:g} to {self.farthest:g} m" if self.nearest else f"up to {self.farthest:g} m"

    def misses(self, depth: Image) -> NDArray[np.bool_]:
        """(h, w) where a depth (h, w) [m] lies outside; not where it is NaN."""
        return np.asarray((depth < self.nearest) | (depth > self.farthest))

    def told(self, depth: Image, name: str) -> str:
        """What a sensor of that name will miss of depths (...) [m], as a sentence; "" where that is nothing."""
        seen = depth[np.isfinite(depth)]
        share = float(np.mean(self.misses(seen))) if seen.size else 0.0
        if not share:
            return ""
        return f"{100 * share:.3g} % of what is seen lies outside the depths of {name} ({self}) and has no value"


ANY = WorkingRange()
