"""A parameter of a sensor effect: its unit, neutral value, bounds, meaning and source travel with the field."""

from dataclasses import MISSING, dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

# a number, one value per harmonic or band (n,), one value per pixel (height, width), or a table
Value = float | NDArray[np.float64]


@dataclass(frozen=True)
class Parameter:
    """What is known about a parameter before any recording is seen."""

    name: str  # of the dataclass field
    unit: str  # "m", "px", "1", ..
    # the value of an effect that is not there; where an effect has several parameters, all at neutral change nothing,
    # and the neutral value of a pure shape (a period, an exponent) is a usual one
    neutral: float
    # low, high: bounds, both allowed
    low: float
    high: float
    meaning: str  # one sentence for a person
    source: str  # where the law comes from
    typical: float  # a usual size, clearly visible: used in plots, tests and as the start of a fit
    group: str = ""  # parameters of one group are given together; a sensor need not have every group
    # "number" (or a map of numbers), "scalar" (the same for all pixels), "list" (one value per harmonic or band; all
    # lists of an effect have the same length), "map" (height, width) or "table" (one dimension per variable)
    kind: str = "number"
    label: str = ""  # the name in files and verdicts; two parameters may share it where the unit tells which is meant
    # values that a search for an unknown effect goes through, for a shape that no linear fit can find
    search: tuple[float, ...] = ()
    # values from which a fit begins of a shape that the search leaves as it is: it is asked for where the effect with
    # it would explain what else takes a second effect
    release: tuple[float, ...] = ()


@dataclass(frozen=True)
class Setting:
    """A field of an effect that is no number: it says how the parameters are laid out."""

    name: str  # of the dataclass field, in files and in verdicts
    kind: str  # "words", or "numbers" (lists of numbers)
    meaning: str  # one sentence for a person


def parameter(
    unit: str,
    bounds: tuple[float, float],
    meaning: str,
    source: str,
    group: str = "",
    *,
    neutral: float = 0.0,
    typical: float | None = None,
    kind: str = "number",
    label: str = "",
    search: tuple[float, ...] = (),
    release: tuple[float, ...] = (),
) -> Any:
    """A dataclass field of an effect; its default is the neutral value.

    `typical` is a tenth of the upper bound unless given, or the neutral value where that is not 0.

    >>> size = fusion.parameter("m", (-0.1, 0.1), "error at 1 m", "measured on two units", typical=0.002)
    """
    usual = typical if typical is not None else (neutral or 0.1 * bounds[1])
    about = {"unit": unit, "neutral": neutral, "low": bounds[0], "high": bounds[1], "meaning": meaning}
    about |= {"source": source, "typical": usual, "group": group, "kind": kind, "search": search, "release": release}
    return field(default=neutral, metadata={"about": (about, label)})


def parameters(effect: Any) -> dict[str, Parameter]:
    """The parameters of an effect (class or instance), by name, in the order of its fields."""
    found = {}
    for entry in fields(effect):
        if "about" in entry.metadata and entry.default is not MISSING:
            about, label = entry.metadata["about"]
            found[entry.name] = Parameter(entry.name, label=label or entry.name, **about)
    return found


def setting(kind: str, meaning: str) -> Any:
    """A dataclass field of an effect that is no number; empty by default."""
    return field(default=(), metadata={"setting": (kind, meaning)})


def settings(effect: Any) -> dict[str, Setting]:
    """The settings of an effect (class or instance), by name."""
    return {e.name: Setting(e.name, *e.metadata["setting"]) for e in fields(effect) if "setting" in e.metadata}
