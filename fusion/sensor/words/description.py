"""A sensor model as rows for a person: every value with its unit, how well it is known, meaning and source."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from fusion.geometry.camera import Principle
from fusion.sensor.effect import Effect
from fusion.sensor.parameter import parameters, settings
from fusion.sensor.sensor import Sensor
from fusion.sensor.working_range import ANY

LONGEST = 64  # numbers that are given one by one; a longer table is told by its shape, mean and rms


@dataclass(frozen=True)
class MapSummary:
    """What is told of a map or a long table."""

    shape: tuple[int, ...]
    mean: float
    rms: float


@dataclass(frozen=True)
class DescribedParameter:
    """One parameter."""

    value: Any  # a number, words, a list of them, or what is told of a map
    unit: str
    std: Any  # 0 where the value is exact, None where nobody knows how well it is known
    meaning: str
    source: str


@dataclass(frozen=True)
class DescribedEffect:
    """One effect with the parameters of the groups that the sensor uses."""

    effect: str
    source: str
    not_corrected: str
    parameters: dict[str, DescribedParameter]


@dataclass(frozen=True)
class SensorDescription:
    """All of a sensor model, its effects in light-path order."""

    name: str
    principle: Principle
    sensor: str
    serial: str
    baseline_m: float
    gives_values: str
    effects: tuple[DescribedEffect, ...]
    left_out: tuple[str, ...]
    warnings: tuple[str, ...]


def description(sensor: Sensor) -> SensorDescription:
    """A sensor model for a person, and for JSON."""
    effects = [
        DescribedEffect(
            effect.name,
            sensor.sources.get(effect.name, ""),
            sensor.why_not_corrected(effect),
            _parameters(effect, sensor),
        )
        for effect in sensor.effects
    ]
    return SensorDescription(
        name=sensor.name,
        principle=sensor.principle,
        sensor=sensor.sensor,
        serial=sensor.serial,
        baseline_m=sensor.baseline,
        gives_values="" if sensor.works == ANY else f"{sensor.works} ({sensor.works.source or 'no source'})",
        effects=tuple(effects),
        left_out=tuple(sensor.left_out),
        warnings=tuple(sensor.warnings),
    )


def _parameters(effect: Effect, sensor: Sensor) -> dict[str, DescribedParameter]:
    """Those of the groups that the sensor uses; of two units of one name, the one in use."""
    rows: dict[str, DescribedParameter] = {}
    for name, layout in settings(effect).items():
        if value := getattr(effect, name):
            rows[name] = DescribedParameter(_plain(value), "", None, layout.meaning, "")
    known = list(parameters(effect).values())
    used = {p.group for p in known if np.any(getattr(effect, p.name) != p.neutral)}
    for about in known:
        value = getattr(effect, about.name)
        unused = about.group not in used if about.group else False
        doubled = about.label in rows and not np.any(value != about.neutral)
        if unused or doubled:
            continue
        std = sensor.std.get((effect.name, about.name))
        rows[about.label] = DescribedParameter(_value(value), about.unit, _plain(std), about.meaning, about.source)
    return rows


def _value(value: Any) -> Any:
    array = np.asarray(value, float)
    if array.size <= LONGEST:
        return array.tolist()
    return MapSummary(array.shape, float(array.mean()), float(np.sqrt((array**2).mean())))


def _plain(value: Any) -> Any:
    """Tuples as lists, all the way down."""
    if isinstance(value, Iterable) and not isinstance(value, str):
        return [_plain(one) for one in value]
    return value
