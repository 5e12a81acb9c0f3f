"""Where an effect acts: everywhere, or only where some variables are within bounds."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from msgspec import Struct

from fusion.errors import SensorError
from fusion.sensor.laws.disparity import disparity
from fusion.sensor.view import Image, View

# each variable as an array that broadcasts to (h, w), or None where it is not known
VARIABLES: dict[str, Callable[[Image, View], Any]] = {
    "depth": lambda depth, view: depth,
    "range": lambda depth, view: depth * view.stretch,
    "disparity": disparity,
    "u": lambda depth, view: view.u,
    "v": lambda depth, view: view.v,
    "radius": lambda depth, view: view.radius,
    "incidence": lambda depth, view: view.incidence,
    "amplitude": lambda depth, view: view.ir,
    "reflectance": lambda depth, view: view.reflectance,
    "edge": lambda depth, view: None if view.edges is None else view.edges.distance,
    "time": lambda depth, view: view.moment.time,
    "temperature": lambda depth, view: view.moment.temperature,
    "table_angle": lambda depth, view: view.moment.table_angle,
    "ambient": lambda depth, view: view.moment.ambient,
}


MOST = 1e9  # JSON has no infinity


class BoundFields(Struct, frozen=True, kw_only=True):
    """Where an effect acts: one variable within bounds, both included; a billion stands for infinity."""

    variable: Literal[tuple(VARIABLES)]  # type: ignore[valid-type]
    low: float
    high: float


@dataclass(frozen=True)
class Bound:
    """One variable within bounds."""

    variable: str  # its name, of `VARIABLES`
    # low, high: both included; infinite where open
    low: float = -np.inf
    high: float = np.inf

    def __post_init__(self) -> None:
        if self.variable not in VARIABLES:
            raise SensorError("an effect cannot be confined by this variable", found=str(self.variable)[:40])

    def entry(self) -> BoundFields:
        """As it stands in files."""
        low, high = (float(np.clip(end, -MOST, MOST)) for end in (self.low, self.high))
        return BoundFields(variable=self.variable, low=low, high=high)


def inside(where: Sequence[Bound], depth: Image, view: View) -> Any:
    """True (broadcasts to (h, w)) where all bounds hold; the true depth decides where it is known."""
    seen = depth if view.depth is None else view.depth
    out: Any = np.True_
    for bound in where:
        value = VARIABLES[bound.variable](seen, view)
        if value is None:
            return np.False_
        out = out & (value >= bound.low) & (value <= bound.high)
    return out
