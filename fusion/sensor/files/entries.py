"""One entry of a sensor file as an effect: its values, where it acts, how well it is known."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from msgspec import UNSET

from fusion.errors import SensorError
from fusion.files.content import Content
from fusion.sensor.catalogue import IMPLEMENTED, KNOWN
from fusion.sensor.effect import Effect
from fusion.sensor.files.raw_values import Raw, numbers, setting_of, std_of, value_of
from fusion.sensor.files.sensor_fields import BoundFields, EffectEntry, GivenParameter, sensor_file
from fusion.sensor.parameter import Parameter, parameters, settings
from fusion.sensor.where import MOST, Bound

Stds = dict[tuple[str, str], float | tuple[float, ...]]


@dataclass(frozen=True)
class GivenEffect:
    """What a file says of one effect."""

    name: str  # of the effect
    entry: EffectEntry  # source, place, fitted
    given: Mapping[str, GivenParameter]  # its parameters by their names in the file
    place: int  # position among the file's effects
    content: Content  # of the whole file, for messages

    def raw(self, label: str, key: str) -> Raw:
        """What stands under a key ("value" or "std") of a parameter."""
        inside = ("effects", self.place, "parameters", label)
        bare = not isinstance(self.content.value["effects"][self.place]["parameters"][label], dict)
        place = inside if bare else (*inside, key)
        return Raw(getattr(self.given[label], key), self.content, place)

    def effect(self) -> Effect:
        """The effect, which is computed; a parameter that is not given stays neutral."""
        kind = IMPLEMENTED[self.name]
        values: dict[str, Any] = {
            key: setting_of(self.raw(key, "value"), about) for key, about in settings(kind).items() if key in self.given
        }
        for about in self.meant():
            values[about.name] = value_of(self.raw(about.label, "value"), about)
        where = tuple(self._bound(index, bound) for index, bound in enumerate(self.entry.where or ()))
        try:
            return replace(kind(**values), where=where)
        except SensorError as error:  # values that do not fit each other
            raise SensorError(error.what, self.content.where, error.found, error.expected, error.do) from error

    def stds(self, effect: Effect) -> Stds:
        """How well the values are known, by (effect, field)."""
        known = [about for about in self.meant() if self.given[about.label].std is not None]
        return {
            (self.name, about.name): std_of(self.raw(about.label, "std"), np.shape(getattr(effect, about.name)))
            for about in known
        }

    def meant(self) -> list[Parameter]:
        """The parameters that are given; where two share a name the unit tells which is meant."""
        found: dict[str, Parameter] = {}
        for about in parameters(IMPLEMENTED[self.name]).values():
            given = self.given.get(about.label)
            if given and about.label not in found and (given.unit or about.unit) == about.unit:
                found[about.label] = about
        return list(found.values())

    def missing(self) -> list[str]:
        """A sentence for each parameter that should stand beside the given ones, and for each unit that decides."""
        if not self.given:
            return [f"{self.name} has no parameters and changes nothing"]
        name, meant = self.name, self.meant()
        groups = {about.group for about in meant}
        absent = [p for p in parameters(IMPLEMENTED[name]).values() if p.group in groups and p.label not in self.given]
        return [f"{name}.{p.label} is not given: {p.neutral:g} {p.unit} is used" for p in absent] + [
            f"the unit of {name}.{about.label} is not given: {about.unit} is used"
            for about in meant
            if not self.given[about.label].unit and len(KNOWN[name][about.label]) > 1
        ]

    def _bound(self, index: int, bound: BoundFields) -> Bound:
        if bound.low > bound.high:
            place = ("effects", self.place, "where", index)
            raise self.content.wrong(sensor_file(), *place, expected="low of at most high: else it acts nowhere")
        low, high = bound.low, bound.high
        return Bound(bound.variable, -np.inf if low <= -MOST else low, np.inf if high >= MOST else high)


def given_effects(content: Content) -> list[GivenEffect]:
    """The effects of a file, each once. Raises SensorError where it does not fit the type of a sensor file."""
    found: dict[str, GivenEffect] = {}
    for place, entry in enumerate(content.as_type(sensor_file()).effects):
        name = entry.__struct_config__.tag
        if name in found:
            raise SensorError(f"{name} is given twice", content.where, do="keep one of the two")
        values = {label: getattr(entry.parameters, label) for label in KNOWN[name]}
        given = {
            label: value if isinstance(value, GivenParameter) else GivenParameter(value=value)
            for label, value in values.items()
            if value is not UNSET
        }
        found[name] = GivenEffect(name, entry, given, place, content)
        if name not in IMPLEMENTED:
            for label in given:
                numbers(found[name].raw(label, "value"))
    return list(found.values())
