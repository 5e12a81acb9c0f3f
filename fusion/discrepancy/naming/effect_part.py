"""Part: one named form with its weights, and the sensor model that holds several of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.naming.search.candidates import Candidate, map_of
from fusion.discrepancy.observe.observations import Observations
from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Parameter, parameters
from fusion.sensor.sensor import Sensor

Vector = NDArray[np.float64]

FIELD = 8  # atoms from which on a form is a field: its weights are draws of one size, not laws of their own


@dataclass(frozen=True)
class EffectPart:
    """One form of one effect, as fitted."""

    candidate: Candidate  # the form, with its columns
    weights: Vector  # (k,) of the atoms
    size: float = 0.0  # usual size of the weights of a field; 0 for others, whose weights are free

    @property
    def name(self) -> str:
        return self.candidate.name

    @property
    def footprint(self) -> Vector:
        """(n,) what it changes, in units of the covariance."""
        return np.asarray(self.candidate.white @ self.weights)

    def effect(self, observations: Observations) -> Effect:
        """The effect with fitted parameters."""
        form = self.candidate.form
        whole = map_of(observations, form, self.weights) if form.map else form.combined(list(self.weights))
        return replace(whole, where=self.candidate.where)

    def at_bound(self, observations: Observations) -> bool:
        """True when a fitted number ended where its range ends: the law is bent to something that it is not."""
        effect, form = self.effect(observations), self.candidate.form
        fitted = {name for atom in form.atoms for name in atom}
        # a value that the search itself begins or ends with is no bent one
        searched = {name for name, value in form.fixed.items() if np.ndim(value) == 0}
        about = [p for p in parameters(effect).values() if p.kind != "map" and p.name in fitted | searched]
        # nor is one that stands in the form, as the column at which a band begins
        given = {(name, v) for atom in form.atoms for name, value in atom.items() for v in np.ravel(value).tolist()}
        return any(
            _ended(p, value) and value not in p.search and (p.name, value) not in given
            for p in about
            for value in np.ravel(getattr(effect, p.name)).tolist()
        )


def _ended(about: Parameter, value: float) -> bool:
    """At an end of the range, which is neither "none" nor "all of it" (a share of 1)."""
    return value in (about.low, about.high) and value != about.neutral and not (about.unit == "1" and value == 1.0)


def is_field(candidate: Candidate) -> bool:
    """True when the form is a map or another long list of equal terms."""
    return candidate.columns.shape[1] >= FIELD


def model_of(observations: Observations, parts: Sequence[EffectPart]) -> Sensor:
    """The sensor of the observations with all parts added."""
    sensor = observations.sensor
    for part in parts:
        effect = part.effect(observations)
        known = sensor.effect(effect.name)
        sensor = sensor.having(effect if known is None else joined(known, effect))
    return sensor


def joined(own: Effect, more: Effect) -> Effect:
    """Two effects of one kind as one: lists are continued, other sizes added up."""
    about = parameters(own)
    lists = [name for name, p in about.items() if p.kind == "list"]
    values: dict[str, Any] = {}
    if lists and any(np.any(getattr(own, name)) for name in lists):
        values = {name: np.concatenate([np.atleast_1d(getattr(e, name)) for e in (own, more)]) for name in lists}
    for name, p in about.items():
        if name not in values and p.neutral == 0 and name not in lists:
            total = np.asarray(getattr(own, name)) + np.asarray(getattr(more, name))
            values[name] = np.clip(total, p.low, p.high) if np.ndim(total) else float(np.clip(total, p.low, p.high))
    return replace(own, **values)
