"""Families: simple functions of one variable, and their products with others, that an unknown law may be made of."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

Vector = NDArray[np.float64]

UNITS = {
    "depth": "m", "range": "m", "disparity": "px", "u": "px", "v": "px", "radius": "px", "incidence": "rad",
    "amplitude": "counts", "reflectance": "", "time": "s", "temperature": "degC", "table_angle": "rad",
    "ambient": "lux",
}  # fmt: skip
# [px] along rows and columns a wave shorter than two tiles looks like a longer one; rings cross the tiles at all angles
FINEST = {"u": 32.0, "v": 32.0, "radius": 20.0}
MOST_WAVES = 9.0  # over the span of a variable, where nothing else bounds them
POWERS = (1.0, 2.0, 3.0, -1.0, -2.0, 0.5, -0.5)
STEPS = 10
POSITIVE = ("depth", "range", "disparity", "amplitude", "reflectance")  # of which any power makes sense
SPAN = 1.5  # largest over smallest value, from which on powers differ from a line


@dataclass(frozen=True)
class ShapeFunction:
    """A function of one variable, spanned by one or two columns."""

    kind: str  # "power", "log", "wave", "log wave", "decay", "tan2" or "step"
    variable: str  # name as in verdicts
    number: float = 1.0  # exponent, period, time constant or place of the step
    unit: float = 1.0  # value of the variable at which a power is 1, or the start of a decay

    @property
    def tunable(self) -> bool:
        return self.kind in ("wave", "log wave", "decay")

    def columns(self, x: ArrayLike) -> Vector:
        """(..., k) values at x (...)."""
        return np.stack(_KINDS[self.kind](np.asarray(x, float), self.number, self.unit), axis=-1)

    def tuned(self, number: float) -> "ShapeFunction":
        return replace(self, number=float(number))

    def text(self) -> str:
        """As words and numbers, without size and phase."""
        name, unit = self.variable, UNITS.get(self.variable, "")
        number = f"{self.number:.3g} {unit}".strip()
        return {
            "power": f"({name} / {self.unit:.3g} {unit})^{self.number:g}".replace("^1", "") if self.unit else "",
            "log": f"log({name} / {self.unit:.3g} {unit})",
            "wave": f"sin(2 pi {name} / {number})",
            "log wave": f"sin({self.number:.3g} log {name})",
            "decay": f"exp(-({name} - {self.unit:.3g} {unit}) / {number})",
            "tan2": f"tan^2 {name}",
            "step": f"a step at {name} = {number}",
        }[self.kind]


def _positive(x: Vector) -> Vector:
    return np.maximum(x, 1e-6)


_KINDS: dict[str, Callable[[Vector, float, float], list[Vector]]] = {
    "power": lambda x, p, x0: [np.sign(x) ** p * np.abs(x / x0) ** p if p in (1.0, 3.0) else (_positive(x) / x0) ** p],
    "log": lambda x, _, x0: [np.log(_positive(x) / x0)],
    "wave": lambda x, period, _: [np.sin(2 * np.pi * x / period), np.cos(2 * np.pi * x / period)],
    "log wave": lambda x, k, _: [np.sin(k * np.log(_positive(x))), np.cos(k * np.log(_positive(x)))],
    "decay": lambda x, tau, x0: [np.exp(-np.maximum(x - x0, 0.0) / tau)],
    "tan2": lambda x, _, __: [np.tan(np.clip(x, -1.4, 1.4)) ** 2],
    "step": lambda x, c, _: [(x > c).astype(float)],
}


def shapes_of(variable: str, values: Vector) -> Iterator[ShapeFunction]:
    """All simple functions of a variable that these values (n,) can tell apart."""
    low, middle, high = (float(x) for x in np.quantile(values, (0.0, 0.5, 1.0)))
    span, several = high - low, len(np.unique(np.round(values, 9)))
    unit = _round(max(abs(middle), 1e-9))
    yield ShapeFunction("power", variable, 1.0, unit)
    if variable in POSITIVE and low > 0 and high > SPAN * low:
        for power in POWERS[1:]:
            yield ShapeFunction("power", variable, power, unit)
        yield ShapeFunction("log", variable, 1.0, unit)
    elif several > 2:
        yield from (ShapeFunction("power", variable, power, unit) for power in (2.0, 3.0) if low >= 0 or power == 3.0)
    if several > 4:  # a sine with its period has three numbers
        finest = FINEST.get(variable, span / MOST_WAVES)
        for waves in np.arange(0.5, max(span / finest, 1.0), 0.25):
            yield ShapeFunction("wave", variable, span / waves)
    if variable == "amplitude" and low > 0 and high > 3 * low:
        yield from (ShapeFunction("log wave", variable, k) for k in np.arange(1.5, 9.1, 0.5))
    if variable == "time":
        yield from (ShapeFunction("decay", variable, span * share, low) for share in (0.05, 0.12, 0.3, 0.7))
    if variable == "incidence":
        yield ShapeFunction("tan2", variable)
    for cut in np.unique(np.quantile(values, np.linspace(0.1, 0.9, STEPS - 1))):
        yield ShapeFunction("step", variable, float(cut))


def _round(value: float) -> float:
    """A number with one digit, near to a value."""
    place = 10.0 ** np.floor(np.log10(value))
    return float(np.round(value / place) * place)
