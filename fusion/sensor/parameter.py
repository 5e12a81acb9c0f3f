"""A parameter of a sensor effect: its unit, neutral value, bounds, meaning and source travel with the field."""

from dataclasses import MISSING, dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

# a number, one value per harmonic (n,), or one value per pixel (height, width)
Value = float | NDArray[np.float64]


@dataclass(frozen=True)
class Parameter:
    """What is known about a parameter before any recording is seen.

    Attributes:
        name: as in files and verdicts.
        unit: "m", "px", "1", ...
        neutral: the value that changes nothing.
        low, high: bounds, both allowed.
        meaning: one sentence for a person.
        source: where the law comes from.
        group: parameters of one group are given together; a sensor need not have every group.
    """

    name: str
    unit: str
    neutral: float
    low: float
    high: float
    meaning: str
    source: str
    group: str = ""


def parameter(unit: str, bounds: tuple[float, float], meaning: str, source: str, group: str = "") -> Any:
    """A dataclass field of an effect; its neutral value is always 0, the absence of the error."""
    return field(default=0.0, metadata={"about": (unit, 0.0, *bounds, meaning, source, group)})


def parameters(effect: Any) -> dict[str, Parameter]:
    """The parameters of an effect (class or instance), by name, in the order of its fields."""
    found = {}
    for entry in fields(effect):
        if "about" in entry.metadata and entry.default is not MISSING:
            found[entry.name] = Parameter(entry.name, *entry.metadata["about"])
    return found
