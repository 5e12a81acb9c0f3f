"""Forms: the shapes an effect can take, each spanned by a few instances, so that a linear fit finds its size."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Parameter, parameters

ANGLES = ("phase", "direction")  # a size at an angle is the sum of sizes at right angles
SMALL = 0.05  # of a typical size: small enough to be linear, far above rounding

Atom = Mapping[str, ArrayLike]  # values of parameters: numbers, lists, maps


@dataclass(frozen=True)
class Form:
    """One shape of an effect."""

    kind: type[Effect]  # the effect
    fixed: dict[str, Any] = field(default_factory=dict)  # values of its shape parameters
    atoms: tuple[Atom, ...] = ()  # values of the other parameters of instances that span it
    map: str = ""  # name of the parameter that is a map (height, width), for a form that has one; atoms are then empty
    # makes parameter values of atoms and their weights
    join: Callable[[Sequence[Atom], Sequence[float]], Atom] | None = None

    def instances(self) -> tuple[Effect, ...]:
        """The effects that span this form."""
        values: list[dict[str, Any]] = [{**self.fixed, **atom} for atom in self.atoms]
        return tuple(self.kind(**each) for each in values)

    def combined(self, weights: Sequence[float]) -> Effect:
        """The effect that a linear fit with these weights of the atoms found; values are held inside their bounds."""
        values = (self.join or _summed)(self.atoms, weights)
        about = parameters(self.kind)
        return self.kind(**self.fixed, **{name: _bounded(value, about[name]) for name, value in values.items()})


def forms_of(kind: type[Effect], shape: tuple[int, int]) -> list[Form]:
    """All shapes of an effect for images of `shape` (h, w); an effect may say them itself (`own_forms`)."""
    own: Callable[[tuple[int, int]], list[Form]] | None = getattr(kind, "own_forms", None)
    if own is not None:
        return own(shape)
    about = parameters(kind)
    searched = {p.name: p.search for p in about.values() if p.search}
    out = []
    for group in dict.fromkeys(p.group for p in about.values()):
        members = [p for p in about.values() if p.group == group]
        sizes = [p for p in members if p.neutral == 0 and p.name not in searched and p.name not in ANGLES]
        for p in sizes:
            if p.kind == "map":
                out += [Form(kind, fixed, map=p.name) for fixed in _fixed(searched)]
        numbers = [p for p in sizes if p.kind in ("number", "scalar", "list") and p.name != "rms"]
        angle = next((p.name for p in members if p.name in ANGLES), None)
        shapes = {name: values for name, values in searched.items() if about[name].group == group}
        for used, fixed in product(_one_unit_each(numbers), _fixed(shapes)):
            if angle:
                height = {used[0].name: SMALL * used[0].typical}
                out.append(Form(kind, fixed, ({**height, angle: 0.0}, {**height, angle: np.pi / 2}), join=_wave))
            else:
                out.append(Form(kind, fixed, tuple({p.name: SMALL * p.typical} for p in used)))
    return out


def _one_unit_each(numbers: list[Parameter]) -> list[list[Parameter]]:
    """Parameters that share a name in two units are alternatives: a file holds one of them."""
    labels = [p.label for p in numbers]
    twice = [p for p in numbers if labels.count(p.label) > 1]
    once = [p for p in numbers if p not in twice]
    return [[*once, p] for p in twice] if twice else [once] if once else []


def _fixed(searched: dict[str, tuple[float, ...]]) -> list[dict[str, float]]:
    return [dict(zip(searched, values, strict=True)) for values in product(*searched.values())]


def _summed(atoms: Sequence[Atom], weights: Sequence[float]) -> Atom:
    """Each atom is one parameter: its value times its weight."""
    pairs = [(weight, *entry) for weight, atom in zip(weights, atoms, strict=True) for entry in atom.items()]
    return {name: np.multiply(weight, value) for weight, name, value in pairs}


def _wave(atoms: Sequence[Atom], weights: Sequence[float]) -> Atom:
    """A sine and a cosine are one wave with a phase."""
    name = next(key for key in atoms[0] if key not in ANGLES)
    angle = next(key for key in atoms[0] if key in ANGLES)
    return {
        name: np.multiply(np.hypot(weights[0], weights[1]), atoms[0][name]),
        angle: float(np.arctan2(weights[1], weights[0])),
    }


def _bounded(value: Any, about: Parameter) -> Any:
    return np.clip(value, about.low, about.high) if np.ndim(value) else float(np.clip(value, about.low, about.high))
