"""Quantities as text: with the digits that are known, in a unit that a person uses, or not determined at all."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fusion.sensor.forms import ANGLES
from fusion.sensor.parameter import Parameter, parameters

USUAL = 10.0  # times a usual size, or the value itself: a spread of more leaves open what the number is (guess)
ANY_ANGLE = np.pi / np.sqrt(3)  # [rad] standard deviation of an angle that may be anything
NOT_DETERMINED = "not determined"


def is_determined(about: Parameter, value: float, std: float | None) -> bool:
    """False where the data leave a number as open as it was before: its spread tells nothing of its size."""
    if std is None:
        return True  # nobody fitted it
    if about.name in ANGLES:
        return bool(std < 0.9 * ANY_ANGLE)
    usual = max(abs(value), abs(about.typical))
    return bool(std < min(USUAL * usual, (about.high - about.low) / 2))


@dataclass(frozen=True)
class FittedNumber:
    """A fitted number as files hold it; `determined` is False where the data leave it as open as it was."""

    value: float
    std: float
    unit: str
    determined: bool

    def __str__(self) -> str:
        return shown(self.value, self.std, self.unit, self.determined)


def fitted(effect: Any, name: str, value: float, std: float) -> FittedNumber:
    """A fitted number of an effect (class or instance); a number that no effect has has no unit."""
    about = parameters(effect).get(name)
    sure = about is None or is_determined(about, value, std)
    return FittedNumber(float(value), float(std), about.unit if about else "", sure)


def quantity(value: Any, std: float | None, unit: str) -> tuple[str, str, str]:
    """Value, standard deviation and unit as text; small lengths in millimetres."""
    values = np.atleast_1d(np.asarray(value, float))
    if unit.split("/")[0] == "m" and np.abs(values).max(initial=0) < 0.1:
        values, std, unit = values * 1e3, None if std is None else std * 1e3, "m" + unit
    known = std is not None and std > 0
    places = int(np.clip(1 - np.floor(np.log10(std)), 0, 9)) if known and std is not None else -1
    said = [f"{v:.{places}f}" if known and abs(v) < 1e6 else f"{v:.4g}" for v in values[:8]]
    said = [text.lstrip("-") if float(text) == 0 else text for text in said]
    text = ", ".join(said) + (" ..." if len(values) > 8 else "")
    return text, f"{std:.{places}f}" if known else ("exact" if std == 0 else "not given"), "" if unit == "1" else unit


def shown(value: float, std: float | None, unit: str, determined: bool = True) -> str:
    """`value +- std unit` in one text."""
    if not determined:
        return NOT_DETERMINED
    number, spread, unit = quantity(value, std, unit)
    known = std is not None and std > 0
    return " ".join(filter(None, (f"{number} +- {spread}" if known else number, unit)))
