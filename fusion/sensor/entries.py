"""One entry of a sensor file: names, units and values checked against what is known."""

from pathlib import Path
from typing import Any

import numpy as np

from fusion.errors import SensorError
from fusion.sensor.catalogue import IMPLEMENTED, KNOWN
from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Parameter, Value, parameters


def checked_entry(entry: Any, path: Path) -> tuple[str, dict[str, dict[str, Any]]]:
    """Name and parameters of an entry; each parameter a dict with "value". Raises SensorError."""
    name = entry.get("effect") if isinstance(entry, dict) else None
    if not isinstance(name, str) or name not in KNOWN:
        raise SensorError("unknown effect", path, repr(name), "one of " + ", ".join(sorted(KNOWN)))
    given = entry.get("parameters", {})
    if not isinstance(given, dict):
        raise SensorError(f"the parameters of {name} are no object", path, type(given).__name__, "{NAME: {...}}")
    for key in given:
        if key not in KNOWN[name]:
            raise SensorError(f"unknown parameter of {name}", path, repr(key), "one of " + ", ".join(KNOWN[name]))
    full = {key: value if isinstance(value, dict) else {"value": value} for key, value in given.items()}
    for key, value in full.items():
        unit, units = value.get("unit"), KNOWN[name][key]
        if units and unit not in (None, *units):
            raise SensorError(f"wrong unit of {name}.{key}", path, unit, " or ".join(units), "convert the value")
        if "value" not in value:
            raise SensorError(f"{name}.{key} has no value", path)
    return name, full


def effect_of(name: str, given: dict[str, dict[str, Any]], path: Path) -> Effect:
    """The implemented effect of a checked entry; a parameter that is not given stays neutral."""
    about = parameters(IMPLEMENTED[name])
    values = {key: _value(entry["value"], f"{name}.{key}", about[key], path) for key, entry in given.items()}
    return IMPLEMENTED[name](**values)


def stds_of(name: str, given: dict[str, dict[str, Any]], path: Path) -> dict[tuple[str, str], float]:
    """How well the values of a checked entry are known, by (effect, parameter)."""
    found = {}
    for key, entry in given.items():
        if entry.get("std") is not None:
            found[name, key] = float(_numbers(entry["std"], f"the std of {name}.{key}", path))
            if found[name, key] < 0:
                raise SensorError(f"the std of {name}.{key} is negative", path, found[name, key], "0 or more")
    return found


def missing_parameters(name: str, given: dict[str, Any]) -> list[str]:
    """A sentence for each parameter that should stand beside the given ones."""
    about = parameters(IMPLEMENTED[name]).values()
    if not given:
        return [f"{name} has no parameters and changes nothing"]
    groups = {p.group for p in about if p.name in given}
    absent = [p for p in about if p.group in groups and p.name not in given]
    return [f"{name}.{p.name} is not given: {p.neutral:g} {p.unit} is used" for p in absent]


def _value(raw: Any, where: str, about: Parameter, path: Path) -> Value:
    array = _numbers(raw, where, path)
    shapes = {"list": (0, 1), "map": (0, 2), "number": (0, 2)}
    expected = {"list": "one number or a list", "map": "a map (height, width)"}
    if array.ndim not in shapes[about.kind]:
        must = expected.get(about.kind, "one number or a map (height, width)")
        raise SensorError(f"{where} has {array.size} values", path, f"shape {array.shape}", must)
    if array.min() < about.low or array.max() > about.high:
        raise SensorError(
            f"{where} is out of bounds",
            path,
            f"{array.min():g} to {array.max():g} {about.unit}" if array.ndim else f"{array:g} {about.unit}",
            f"{about.low:g} to {about.high:g} {about.unit}",
            "check the unit",
        )
    return array if array.ndim else float(array)


def _numbers(raw: Any, where: str, path: Path) -> np.ndarray:
    try:
        if isinstance(raw, str):
            if not raw.endswith(".npy"):
                raise ValueError("text")
            raw = np.load(path.parent / raw, allow_pickle=False)
        array = np.asarray(raw, float)
    except (OSError, ValueError, TypeError, EOFError) as error:
        expected = "a number, a list of numbers or a .npy file beside the sensor file"
        raise SensorError(f"{where} cannot be read", path, repr(raw)[:60], expected) from error
    if array.size == 0 or not np.isfinite(array).all():
        raise SensorError(f"{where} is empty or not finite", path, repr(raw)[:60], "finite numbers")
    return array
