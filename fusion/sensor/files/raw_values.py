"""Values as they stand in a sensor file, as numbers and words; whatever else stands there is one clear error."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.errors import SensorError
from fusion.files.content import Content
from fusion.files.inside import inside
from fusion.files.npy import read_npy
from fusion.files.places import Place, place_words
from fusion.sensor.files.sensor_fields import sensor_file
from fusion.sensor.parameter import Parameter, Setting, Value

_SHAPES = {"number": (0, 2), "scalar": (0,), "list": (0, 1), "map": (0, 2), "table": tuple(range(32))}
_EXPECTED = {"scalar": "one number", "list": "one number or a list", "table": "a table"}


@dataclass(frozen=True)
class Raw:
    """A number, a list, words or a file's name, and where they stand."""

    value: Any
    content: Content
    place: Place

    def wrong(self, found: str = "", expected: str = "") -> SensorError:
        """The error of this value."""
        error = self.content.wrong(sensor_file(), *self.place, found=found, expected=expected)
        assert isinstance(error, SensorError)
        return error


def value_of(raw: Raw, about: Parameter) -> Value:
    """A number, or an array of the parameter's kind, within its bounds."""
    array = numbers(raw)
    if array.ndim not in _SHAPES[about.kind]:
        must = _EXPECTED.get(about.kind, "one number or a map (height, width)")
        raise raw.wrong(f"shape {array.shape}", must)
    low, high = np.min(array), np.max(array)
    if low < about.low or high > about.high:
        unit = about.unit
        found = f"{low:g} to {high:g} {unit}" if array.ndim else f"{array:g} {unit}"
        raise raw.wrong(found, f"{about.low:g} to {about.high:g} {unit}")
    return array if array.ndim else float(array)


def setting_of(raw: Raw, about: Setting) -> tuple[Any, ...]:
    """Words, or one tuple of numbers per word; one word or one list may stand alone."""
    given = raw.value
    if about.kind == "words":
        return (given,) if isinstance(given, str) else tuple(given)
    lists = given if not given or isinstance(given[0], list) else [given]
    return tuple(tuple(np.atleast_1d(_finite(one, raw)).ravel().tolist()) for one in lists)


def std_of(raw: Raw, shape: tuple[int, ...]) -> float | tuple[float, ...]:
    """How well a value of some shape is known: one number, or one for each value of a list."""
    std = numbers(raw)
    if std.ndim and std.shape != shape:
        raise raw.wrong(f"{std.size} values", f"one number or as many as values, {int(np.prod(shape))}")
    if np.min(std) < 0:
        raise raw.wrong(f"{np.min(std):g}", "0 or more")
    return tuple(std.ravel().tolist()) if std.ndim else float(std)


def numbers(raw: Raw) -> NDArray[np.float64]:
    """A number, nested lists of numbers, or the content of a `.npy` file beside the sensor file; finite, not empty."""
    return _finite(raw.value, raw)


def _finite(given: Any, raw: Raw) -> NDArray[np.float64]:
    if isinstance(given, str):
        if not given.endswith(".npy"):
            raise raw.wrong()
        array = _stored(given, raw)
    else:
        try:
            array = np.asarray(given)
        except (ValueError, OverflowError, MemoryError) as problem:  # lists of different lengths, too deep
            raise raw.wrong(expected="a number or lists of one length") from problem
        if array.dtype.kind not in "iuf":  # text or truth values among the numbers, or nothing at all
            raise raw.wrong(expected="numbers")
        array = array.astype(float)
    if array.size == 0 or not np.isfinite(array).all():
        raise raw.wrong(expected="finite numbers, at least one")
    return array


def _stored(name: str, raw: Raw) -> NDArray[np.float64]:
    """The array beside the sensor file."""
    file = Path(str(raw.content.where))
    path = inside(file.parent, name, SensorError, file)
    try:
        return read_npy(path, SensorError, f"the array of {place_words(raw.place, raw.content.value)}")
    except SensorError as error:
        named = f"{error.where}, named in {file.name}"
        raise SensorError(error.what, named, error.found, error.expected, error.do) from error
