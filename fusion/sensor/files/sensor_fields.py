"""What `sensor.json` may hold, as types; those of the effects are made of what the effects declare."""

from functools import cache
from typing import Annotated, Any, Literal, Union

import msgspec
from msgspec import UNSET, Meta, Struct, UnsetType

from fusion.files.content import Name
from fusion.geometry.camera import Principle
from fusion.sensor.catalogue import IMPLEMENTED, KNOWN
from fusion.sensor.parameter import Parameter, Setting, parameters, settings
from fusion.sensor.where import BoundFields

SHAPE: dict[str, Any] = {"frozen": True, "kw_only": True}
FORMAT: Literal["fusion-sensor/1"] = "fusion-sensor/1"

Baseline = Annotated[float, Meta(gt=-10, lt=10, description="place of the projector on the camera's x axis [m]")]
Frequency = Annotated[float, Meta(gt=1e5, lt=1e10, description="modulation [Hz]")]
Std = Annotated[float, Meta(ge=0)]


NpyName = Annotated[str, Meta(extra_json_schema={"pattern": r"\.npy$"}, description="the name of a .npy file")]


class EffectEntry(Struct, frozen=True, kw_only=True):
    """What entries of all effects share."""

    source: Name = None
    fitted: Annotated[bool, Meta(description="the numbers were found together, on this very unit")] = False
    where: Annotated[list[BoundFields], Meta(description="absent or empty: everywhere")] | None = None


class GivenParameter(Struct, frozen=True, kw_only=True):
    """A parameter as it stands in the file."""

    value: Any
    unit: str | None = None
    std: Annotated[Std | NpyName | list[Any] | None, Meta(description="standard deviation; 0: exact")] = None


class RangeFields(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Between which depths the sensor gives values; absent: no such limit."""

    nearest_m: Annotated[float, Meta(ge=0, le=1000)] = 0.0
    farthest_m: Annotated[float, Meta(gt=0, le=1000)] | None = None
    source: Name = None


Increasing = Annotated[list[float], Meta(min_length=2)]


class DepthErrorFields(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Independent errors that a calibration leaves, one standard deviation each, on a grid of pixels and depths."""

    v_px: Annotated[Increasing, Meta(description="rows, increasing")]
    u_px: Annotated[Increasing, Meta(description="columns, increasing")]
    depth_m: Annotated[Increasing, Meta(description="depths, increasing")]
    values_m: Annotated[NpyName | list[Any], Meta(description="[m] by error, row, column and depth")]


class SensorFields(Struct, frozen=True, kw_only=True):
    """All of a sensor model but its effects."""

    format: Literal["fusion-sensor/1"]
    name: Name = None
    principle: Principle | None = None
    sensor: Name = None
    serial: Name = None
    baseline_m: Baseline | None = None
    modulation_hz: Annotated[list[Frequency], Meta(description="modulations [Hz], each from 1e5 to 1e10")] | None = None
    range: RangeFields | None = None
    depth_errors: DepthErrorFields | None = None


@cache
def sensor_file() -> Any:
    """The type of a whole `sensor.json`, with an entry type for every effect that has a name."""
    entries = tuple(_entry(name) for name in KNOWN)
    effects = Annotated[list[Union[entries]], Meta(description="a list of effects, each once; order has no meaning")]  # type: ignore[valid-type] # noqa: UP007
    made = msgspec.defstruct("SensorFile", [("effects", effects)], bases=(SensorFields,), **SHAPE)
    made.__doc__ = "A sensor model: `sensor.json`."
    return made


def _entry(name: str) -> Any:
    kind = IMPLEMENTED.get(name)
    values = {key: _setting(about) for key, about in settings(kind).items()} if kind else {}
    for label, units in KNOWN[name].items():
        declared = [about for about in parameters(kind).values() if about.label == label] if kind else []
        values.setdefault(label, _value(declared))
        values[label] |= _with_unit(f"{name}.{label}", values[label], units) | UnsetType
    fields = [(label, value, UNSET) for label, value in values.items()]
    own = msgspec.defstruct(f"{name}.parameters", fields, **SHAPE, forbid_unknown_fields=True)
    field = ("parameters", own, msgspec.field(default_factory=own))
    return msgspec.defstruct(name, [field], bases=(EffectEntry,), tag_field="effect", tag=name, **SHAPE)


def _setting(about: Setting) -> Any:
    forms = str | list[str] if about.kind == "words" else list[Any]
    return Annotated[forms, Meta(description=about.meaning)]


def _value(declared: list[Parameter]) -> Any:
    """A number, or what holds many: lists, maps and tables are looked at where they are read."""
    if len(declared) != 1:  # where two share a name, the unit tells whose bounds hold
        return Annotated[float | NpyName | list[Any], Meta(description="of any size")]
    about = declared[0]
    number = Annotated[float, Meta(ge=about.low, le=about.high)]
    return Annotated[number | NpyName | list[Any], Meta(description=f"{about.meaning} [{about.unit}]")]


def _with_unit(name: str, value: Any, units: tuple[str, ...]) -> Any:
    unit: Any = Literal[*units, ""] if units else str
    fields: list[tuple[str, Any] | tuple[str, Any, Any]] = [("value", value), ("unit", unit | None, None)]
    return msgspec.defstruct(name, fields, bases=(GivenParameter,), **SHAPE)
