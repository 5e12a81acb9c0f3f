"""Results of many units of one camera, whatever they state: numbers by name, and how far each of them spreads.

The statistics are those of `units`, of quantities instead of depths.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.errors import SensorError
from fusion.simulation.exporting.units import Interval, drift, spreads

DISTORTION = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")


@dataclass(frozen=True)
class Reading:
    """What one result states of a unit."""

    unit: str  # its number or name
    date: float  # years, from any one day on; NaN where it is not known
    values: Mapping[str, float]  # quantity, with its unit in brackets, to its number


@dataclass(frozen=True)
class ResultFigures:
    """One result: of which unit, from which date, and its quantities."""

    unit: str
    date_years: float
    values: NDArray[np.float64]


@dataclass(frozen=True)
class QuantitiesFigures:
    """The content of `units.json`: see `Quantities`."""

    quantities: tuple[str, ...]
    units: tuple[str, ...]
    results: tuple[ResultFigures, ...]
    between: Interval
    within: Interval
    drift: Interval


@dataclass(frozen=True)
class Quantities:
    """m results of u units, with k quantities that all of them state."""

    labels: tuple[str, ...]  # (k,) names of the quantities
    names: tuple[str, ...]  # of the units
    unit: NDArray[np.int64]  # (m,) which each result is of
    date: NDArray[np.float64]  # (m,) [years], NaN where it is not known
    values: NDArray[np.float64]  # (m, k)
    # between, within, drift: as in `Units`, in the quantity's own unit, the drift per year
    between: Interval
    within: Interval
    drift: Interval

    def figures(self) -> QuantitiesFigures:
        """What `units.json` holds."""
        rows = zip(self.unit, self.date, self.values, strict=True)
        results = tuple(ResultFigures(self.names[u], float(d), v) for u, d, v in rows)
        return QuantitiesFigures(self.labels, self.names, results, self.between, self.within, self.drift)


def quantities(readings: Sequence[Reading]) -> Quantities:
    """Compare results of units. SensorError: fewer than two units, or no quantity that all of them state."""
    names = tuple(dict.fromkeys(one.unit for one in readings))
    if len(names) < 2:
        raise SensorError("one unit alone has no spread", found=names, expected="results of two or more units")
    labels = tuple(label for label in readings[0].values if all(label in one.values for one in readings))
    if not labels:
        expected = "recordings that have the same names for all units"
        raise SensorError("the results have no quantity in common", found=", ".join(names)[:80], expected=expected)
    values = np.array([[one.values[label] for label in labels] for one in readings], float)
    unit = np.array([names.index(one.unit) for one in readings])
    date = np.array([one.date for one in readings])
    return Quantities(labels, names, unit, date, values, *spreads(values, unit), drift(values, unit, date))


def stated_by_camera(content: Mapping[str, Any]) -> dict[str, float]:
    """Quantities of a `camera.json`."""
    lens = zip(DISTORTION, content.get("distortion") or (), strict=False)
    return {
        **{f"{name} [px]": float(content[name]) for name in ("fx", "fy", "cx", "cy")},
        **{k: float(v) for k, v in lens},
    }


def stated_by_evaluation(content: Mapping[str, Any]) -> dict[str, float]:
    """Quantities of an `evaluation.json`, of each recording by its name; those that are not known are left out."""
    found: dict[str, float | None] = {}
    for look in content["stretches"]:
        name = look["name"]
        found[f"{name}: offset [m]"] = (look["bias"] or {}).get("offset_m")
        found[f"{name}: axial noise [m]"] = (look["noise"] or {}).get("axial_m")
        found[f"{name}: noise of a pixel [m]"] = (look["depth"]["std_robust_m"] or {}).get("median")
        found[f"{name}: no data [1]"] = look["shares"]["no_data"]
        found[f"{name}: drift in ten minutes [m]"] = look["drift"]["change_ten_minutes_m"]
    return {label: float(value) for label, value in found.items() if value is not None}
