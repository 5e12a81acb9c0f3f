"""One entry of a sensor file: names and units checked against what is known."""

from pathlib import Path
from typing import Any

from fusion.errors import SensorError
from fusion.sensor.catalogue import IMPLEMENTED, KNOWN
from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Parameter, parameters, settings
from fusion.sensor.raw_values import numbers, setting_of, shown, std_of, value_of
from fusion.sensor.where import Bound, bound_of

Given = dict[str, dict[str, Any]]  # by the name in the file: an object with "value" and perhaps "unit" and "std"


def checked_entry(entry: Any, path: Path) -> tuple[str, Given]:
    """Name and parameters of an entry; each parameter a dict with "value". Raises SensorError."""
    name = entry.get("effect") if isinstance(entry, dict) else None
    if not isinstance(name, str) or name not in KNOWN:
        raise SensorError("unknown effect", path, shown(name), "one of " + ", ".join(sorted(KNOWN)))
    given = entry.get("parameters", {})
    if not isinstance(given, dict):
        raise SensorError(f"the parameters of {name} are no object", path, shown(given), "{NAME: {...}}")
    for key in given:
        if key not in KNOWN[name]:
            raise SensorError(f"unknown parameter of {name}", path, shown(key), "one of " + ", ".join(KNOWN[name]))
    full = {key: value if isinstance(value, dict) else {"value": value} for key, value in given.items()}
    for key, value in full.items():
        unit, units = value.get("unit") or None, KNOWN[name][key]
        if units and unit not in (None, *units):
            raise SensorError(f"wrong unit of {name}.{key}", path, shown(unit), " or ".join(units), "convert the value")
        if "value" not in value:
            raise SensorError(f"{name}.{key} has no value", path)
        if name not in IMPLEMENTED and not isinstance(value["value"], str):
            numbers(value["value"], f"{name}.{key}", path)
    return name, full


def effect_of(name: str, given: Given, path: Path) -> Effect:
    """The implemented effect of a checked entry; a parameter that is not given stays neutral."""
    kind = IMPLEMENTED[name]
    values: dict[str, Any] = {
        key: setting_of(given[key]["value"], f"{name}.{key}", about, path)
        for key, about in settings(kind).items()
        if key in given
    }
    for about, entry in _fields(name, given):
        values[about.name] = value_of(entry["value"], f"{name}.{about.label}", about, path)
    try:
        return kind(**values)
    except SensorError as error:  # values that do not fit each other
        raise SensorError(error.what, path, error.found, error.expected, error.do) from error


def where_of(entry: Any, path: Path) -> tuple[Bound, ...]:
    """Where the effect of a checked entry acts; empty: everywhere."""
    given = entry.get("where") or []
    if not isinstance(given, list):
        raise SensorError("where an effect acts is no list", path, shown(given), '[{"variable", "low", "high"}]')
    return tuple(bound_of(bound) for bound in given)


def is_fitted(entry: Any, path: Path) -> bool:
    """Whether the numbers of a checked entry were found together on this very unit."""
    given = entry.get("fitted", False)
    if not isinstance(given, bool):
        raise SensorError("whether an effect is fitted is no truth value", path, shown(given), "true or false")
    return given


def stds_of(effect: Effect, given: Given, path: Path) -> dict[tuple[str, str], float | tuple[float, ...]]:
    """How well the values of a checked entry are known, by (effect, field)."""
    return {
        (effect.name, about.name): std_of(
            entry["std"], f"{effect.name}.{about.label}", getattr(effect, about.name), path
        )
        for about, entry in _fields(effect.name, given)
        if entry.get("std") is not None
    }


def missing_parameters(name: str, given: Given) -> list[str]:
    """A sentence for each parameter that should stand beside the given ones, and for each unit that decides."""
    if not given:
        return [f"{name} has no parameters and changes nothing"]
    groups = {about.group for about, _ in _fields(name, given)}
    absent = [p for p in parameters(IMPLEMENTED[name]).values() if p.group in groups and p.label not in given]
    return [f"{name}.{p.label} is not given: {p.neutral:g} {p.unit} is used" for p in absent] + [
        f"the unit of {name}.{about.label} is not given: {about.unit} is used"
        for about, entry in _fields(name, given)
        if not entry.get("unit") and len(KNOWN[name][about.label]) > 1
    ]


def _fields(name: str, given: Given) -> list[tuple[Parameter, dict[str, Any]]]:
    """The parameters that are given, with their entries; where two share a name the unit tells which is meant."""
    found = {}
    for about in parameters(IMPLEMENTED[name]).values():
        entry = given.get(about.label)
        if entry and about.label not in found and (entry.get("unit") or about.unit) == about.unit:
            found[about.label] = about, entry
    return list(found.values())
