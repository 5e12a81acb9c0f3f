"""Values as they stand in a sensor file, as numbers and words; whatever else stands there is one clear error."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.errors import SensorError
from fusion.sensor.parameter import Parameter, Setting, Value

SHOWN = 60  # characters of a wrong value
_SHAPES = {"number": (0, 2), "scalar": (0,), "list": (0, 1), "map": (0, 2), "table": tuple(range(32))}
_EXPECTED = {"scalar": "one number", "list": "one number or a list", "table": "a table"}


def value_of(raw: Any, where: str, about: Parameter, path: Path) -> Value:
    """A number, or an array of the parameter's kind, within its bounds; `path` is the file it stands in."""
    array = numbers(raw, where, path)
    if array.ndim not in _SHAPES[about.kind]:
        must = _EXPECTED.get(about.kind, "one number or a map (height, width)")
        raise SensorError(f"{where} has {array.size} values", path, f"shape {array.shape}", must)
    if np.min(array) < about.low or np.max(array) > about.high:
        raise SensorError(
            f"{where} is out of bounds",
            path,
            f"{np.min(array):g} to {np.max(array):g} {about.unit}" if array.ndim else f"{array:g} {about.unit}",
            f"{about.low:g} to {about.high:g} {about.unit}",
            "check the unit",
        )
    return array if array.ndim else float(array)


def setting_of(raw: Any, where: str, about: Setting, path: Path) -> tuple[Any, ...]:
    """Words, or one tuple of numbers per word; one word or one list may stand alone."""
    if about.kind == "words":
        words = (raw,) if isinstance(raw, str) else raw
        if not isinstance(words, list | tuple) or not all(isinstance(word, str) for word in words):
            raise SensorError(f"{where} is no list of names", path, shown(raw), '["depth", ...]')
        return tuple(words)
    if not isinstance(raw, list | tuple):
        raise SensorError(f"{where} is no list", path, shown(raw), "a list of numbers per variable")
    lists = raw if not raw or isinstance(raw[0], list | tuple) else [raw]
    return tuple(tuple(np.atleast_1d(numbers(one, where, path)).ravel().tolist()) for one in lists)


def std_of(raw: Any, where: str, value: Value, path: Path) -> float | tuple[float, ...]:
    """How well a value is known: one number, or one for each value of a list."""
    std = numbers(raw, f"the std of {where}", path)
    if std.ndim and std.shape != np.shape(value):
        must = f"one number or as many as values, {np.size(value)}"
        raise SensorError(f"the std of {where} has {std.size} values", path, f"shape {std.shape}", must)
    if np.min(std) < 0:
        raise SensorError(f"the std of {where} is negative", path, f"{np.min(std):g}", "0 or more")
    return tuple(std.ravel().tolist()) if std.ndim else float(std)


def numbers(raw: Any, where: str, path: Path) -> NDArray[np.float64]:
    """A number, nested lists of numbers, or the content of a `.npy` file beside `path`; finite and not empty."""
    array = _array(raw, path)
    if array is None:
        expected = "a number, a list of numbers or a .npy file beside the sensor file"
        raise SensorError(f"{where} cannot be read", path, shown(raw), expected)
    if array.size == 0 or not np.isfinite(array).all():
        raise SensorError(f"{where} is empty or not finite", path, shown(raw), "finite numbers")
    return array


def shown(raw: Any) -> str:
    """A wrong value, shortened, for a message."""
    text = repr(raw)
    return text if len(text) <= SHOWN else text[:SHOWN] + "..."


def _array(raw: Any, path: Path) -> NDArray[np.float64] | None:
    """None for what is no array of numbers: text, truth values, lists of different lengths, broken files."""
    try:
        if isinstance(raw, str):
            raw = np.load(path.parent / raw, allow_pickle=False) if raw.endswith(".npy") else None
        elif not isinstance(raw, int | float | list | tuple):
            return None
        array = np.asarray(raw)
        return array.astype(float) if array.dtype.kind in "iuf" else None
    except (OSError, ValueError, TypeError, KeyError, EOFError, OverflowError, MemoryError, RecursionError):
        return None
