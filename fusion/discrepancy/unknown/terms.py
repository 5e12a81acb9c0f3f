"""Terms of an unknown law: one simple function, or its product with another."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.unknown.families import ShapeFunction

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class UnknownTerm:
    """A product of simple functions of different variables, or one of them times a free line or parabola of another."""

    shapes: tuple[ShapeFunction, ...]  # one or two
    curve: str = ""  # the variable whose free polynomial multiplies them, or ""
    degree: int = 1  # of that polynomial
    # middle, half: of that variable's values
    middle: float = 0.0
    half: float = 1.0

    @property
    def variables(self) -> tuple[str, ...]:
        names = [shape.variable for shape in self.shapes] + ([self.curve] if self.curve else [])
        return tuple(dict.fromkeys(names))

    def columns(self, at: Mapping[str, NDArray[np.floating]]) -> Vector:
        """(..., k) values where the variables have values at[name] (...), which broadcast."""
        out = self.shapes[0].columns(at[self.shapes[0].variable])
        for shape in self.shapes[1:]:
            out = _products(out, shape.columns(at[shape.variable]))
        if self.curve:
            x = (np.asarray(at[self.curve], float) - self.middle) / self.half
            out = _products(out, np.stack([x**power for power in range(self.degree + 1)], axis=-1))
        return out

    def text(self) -> str:
        parts = [shape.text() for shape in self.shapes]
        curve = ("a line", "a parabola")[self.degree - 1] + f" in {self.curve}"
        return " * ".join([*parts, curve] if self.curve else parts)


def _products(a: Vector, b: Vector) -> Vector:
    a, b = a[..., :, None], b[..., None, :]
    out = a * b
    return np.asarray(out.reshape(*out.shape[:-2], -1))
