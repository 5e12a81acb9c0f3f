"""A sensor model as rows for a person: every value with its unit, how well it is known, meaning and source."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.parameter import parameters, settings
from fusion.sensor.sensor import Sensor

LONGEST = 64  # numbers that are given one by one; a longer table is told by its shape, mean and rms


def description(sensor: Sensor) -> dict[str, Any]:
    """All of a sensor model, as JSON holds it.

    Returns:
        "name", "principle", "sensor", "serial", "baseline_m", "effects": a list in light-path order of {"effect",
        "source", "not_undone", "parameters": {name: {"value", "unit", "std", "meaning", "source"}}}, "left_out",
        "warnings". `std` is 0 where the value is exact, None where nobody knows how well it is known. A map's value is
        {"shape", "mean", "rms"}.
    """
    effects = [
        {
            "effect": effect.name,
            "source": sensor.sources.get(effect.name, ""),
            "not_undone": sensor.left(effect),
            "parameters": _parameters(effect, sensor),
        }
        for effect in sensor.effects
    ]
    return {
        "name": sensor.name,
        "principle": sensor.principle,
        "sensor": sensor.sensor,
        "serial": sensor.serial,
        "baseline_m": sensor.baseline,
        "effects": effects,
        "left_out": list(sensor.left_out),
        "warnings": list(sensor.warnings),
    }


def _parameters(effect: Effect, sensor: Sensor) -> dict[str, dict[str, Any]]:
    """Those of the groups that the sensor uses; of two units of one name, the one in use."""
    rows: dict[str, dict[str, Any]] = {}
    for name, layout in settings(effect).items():
        if value := getattr(effect, name):
            rows[name] = _row(_plain(value), "", None, layout.meaning, "")
    known = list(parameters(effect).values())
    used = {p.group for p in known if np.any(getattr(effect, p.name) != p.neutral)}
    for about in known:
        value = getattr(effect, about.name)
        unused = about.group not in used if about.group else False
        doubled = about.label in rows and not np.any(value != about.neutral)
        if unused or doubled:
            continue
        std = sensor.std.get((effect.name, about.name))
        rows[about.label] = _row(_value(value), about.unit, _plain(std), about.meaning, about.source)
    return rows


def _row(value: Any, unit: str, std: Any, meaning: str, source: str) -> dict[str, Any]:
    return {"value": value, "unit": unit, "std": std, "meaning": meaning, "source": source}


def _value(value: Any) -> Any:
    array = np.asarray(value, float)
    if array.size <= LONGEST:
        return array.tolist()
    return {"shape": list(array.shape), "mean": float(array.mean()), "rms": float(np.sqrt((array**2).mean()))}


def _plain(value: Any) -> Any:
    """Tuples as lists, all the way down."""
    if isinstance(value, Iterable) and not isinstance(value, str):
        return [_plain(one) for one in value]
    return value
