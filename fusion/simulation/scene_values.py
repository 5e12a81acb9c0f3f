"""Checked values of a scene file: each error names the key and the file."""

import math
from typing import Any

import numpy as np

from fusion.errors import SceneError
from fusion.geometry.pose import Array, from_tum, is_rigid
from fusion.simulation.course import looking_at

POSE = "a 4x4 matrix, tx ty tz qx qy qz qw, or eye and target"


class Values:
    """A JSON object of a scene file; `unknown` collects the keys that nobody asked for."""

    def __init__(self, content: Any, where: str, notes: list[str]) -> None:
        if not isinstance(content, dict):
            raise SceneError("this is no JSON object", where, _short(content), "{...}")
        self.content, self.where = content, where
        self._asked: set[str] = set()
        self._notes = notes

    def __contains__(self, key: str) -> bool:
        self._asked.add(key)
        return self.content.get(key) is not None

    def any(self, key: str) -> Any:
        """The value as it stands, None where absent."""
        self._asked.add(key)
        return self.content.get(key)

    def below(self, key: str) -> "Values":
        """An object in the object; an empty one where absent."""
        value = self.any(key)
        return Values({} if value is None else value, f'{self.where}, "{key}"', self._notes)

    def number(self, key: str, usual: float | None = None, low: float = -1e9, high: float = 1e9) -> float:
        """A finite number within bounds; `usual` where absent, an error when there is none."""
        value = self.any(key)
        if value is None and usual is not None:
            return usual
        if not is_number(value) or not low <= value <= high:
            raise self.wrong(key, f"a number from {low:g} to {high:g}")
        return float(value)

    def whole(self, key: str, usual: int | None = None, low: int = 0, high: int = 10**9) -> int:
        """A whole number within bounds."""
        value = self.number(key, usual, low, high)
        if value != int(value):
            raise self.wrong(key, "a whole number")
        return int(value)

    def truth(self, key: str, usual: bool) -> bool:
        """true or false."""
        value = self.any(key)
        if value is None:
            return usual
        if not isinstance(value, bool):
            raise self.wrong(key, "true or false")
        return value

    def text(self, key: str, usual: str = "") -> str:
        """A text."""
        value = self.any(key)
        if value is None:
            return usual
        if not isinstance(value, str) or "\0" in value:
            raise self.wrong(key, "a text")
        return value

    def vector(self, key: str, usual: tuple[float, float, float] | None = None) -> tuple[float, float, float]:
        """Three finite numbers."""
        value = self.any(key)
        if value is None and usual is not None:
            return usual
        if not isinstance(value, list) or len(value) != 3 or not all(map(is_number, value)):
            raise self.wrong(key, "three numbers")
        return float(value[0]), float(value[1]), float(value[2])

    def pose(self, *keys: str) -> Array | None:
        """The first pose (4, 4) under one of the keys; None where there is none."""
        for key in keys:
            if key in self:
                return self._pose(key)
        return None

    def _pose(self, key: str) -> Array:
        value = self.any(key)
        if isinstance(value, dict):
            look = self.below(key)
            roll = np.deg2rad(look.number("roll_deg", 0.0))
            return looking_at(np.array(look.vector("eye")), np.array(look.vector("target")), roll)
        try:
            numbers = np.array(value, float)
        except (TypeError, ValueError, OverflowError):
            raise self.wrong(key, POSE) from None
        small = bool(np.isfinite(numbers).all() and numbers.size and np.abs(numbers).max() < 1e9)
        if numbers.shape == (7,) and small and abs(np.linalg.norm(numbers[3:]) - 1) < 0.05:
            return from_tum(numbers)
        if not small or not is_rigid(numbers):
            raise self.wrong(key, POSE)
        return numbers

    def wrong(self, key: str, expected: str) -> SceneError:
        """The error of a value that cannot be used."""
        found = "nothing" if key not in self else _short(self.content[key])
        return SceneError(f'"{key}" of the scene cannot be used', self.where, found, expected)

    def done(self) -> None:
        """Tell which keys were left unread: they are ignored, as in every JSON file."""
        for key in self.content:
            if key not in self._asked:
                self._notes.append(f'{self.where}: "{key}" is not known and ignored')


def is_number(value: Any) -> bool:
    """True for a finite number; a truth value is none."""
    return (
        not isinstance(value, bool) and isinstance(value, int | float) and abs(value) < 1e300 and math.isfinite(value)
    )


def _short(value: Any) -> str:
    return repr(value)[:60]
