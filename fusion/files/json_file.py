"""JSON files from outside: one object, each key once, finite numbers, no deeper than a person would nest them."""

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from fusion.errors import FusionError
from fusion.files.limits import check_size
from fusion.files.places import Place, place_words
from fusion.files.reading import read_text

DEEPEST = 64  # a table of a sensor model has up to 32 dimensions; nothing else comes near
LONGEST_WHOLE = 18  # digits that 64 bits hold; a longer number is taken as a real one
UNPACKED = 100  # bytes that a character may come to take: the objects of `{"a":1},` take 30, and all are looked at
SHOWN = 60  # characters of a wrong value


class _TwiceError(ValueError):
    """A key that stands twice in one object."""


def read_json(path: Path | str, error: type[FusionError] = FusionError, what: str = "the file") -> dict[str, Any]:
    """The JSON object in a file.

    Args:
        path: a regular file of UTF-8 or marked UTF-16 text.

    Raises:
        FusionError: of the kind asked for: the file cannot be read, is no JSON object, holds a key twice, a number
            that is not finite, or nests too deep.
    """
    return json_in(read_text(path, error, what), path, error, what)


def json_in(
    text: str, path: Path | str, error: type[FusionError] = FusionError, what: str = "the file"
) -> dict[str, Any]:
    """The same of a text that stands in another file; `path` names it. Raises as `read_json`."""
    check_size(UNPACKED * len(text), path, error, f"{what} with all its values")
    deep = f"at most {DEEPEST} levels"
    try:
        content = json.loads(text, object_pairs_hook=_once, parse_int=_whole)
    except _TwiceError as problem:
        raise error(
            f"{what} holds a key twice", path, f'"{str(problem)[:SHOWN]}" twice', "each key once", "delete one"
        ) from None
    except json.JSONDecodeError as problem:
        found = f"{problem.msg} (line {problem.lineno}, column {problem.colno})"
        raise error(f"{what} is not valid JSON", path, found, do="correct the file") from problem
    except RecursionError:
        raise error(f"{what} is nested too deep", path, expected=deep) from None
    if not isinstance(content, dict):
        raise error(f"{what} holds no JSON object", path, shown(content), '{"key": value, ...}')
    for place, value in _leaves(content, ()) if _doubtful(content) else ():
        if len(place) > DEEPEST:
            raise error(f"{what} is nested too deep", path, f"{place_words(place[:2], content)} ...", deep)
        if isinstance(value, float) and not math.isfinite(value):
            found = "NaN" if math.isnan(value) else "Infinity, or a number beyond 1e308"
            raise error(f"{place_words(place, content)} cannot be used", path, found, "a finite number")
    return content


def shown(value: object) -> str:
    """A value of a JSON file, shortened, for a message."""
    text = json.dumps(value) if value is None or isinstance(value, bool) else repr(value)
    return text if len(text) <= SHOWN else text[:SHOWN] + "..."


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object; nobody knows which of two values of a key is meant."""
    found = dict(pairs)
    if len(found) < len(pairs):
        keys = [key for key, _ in pairs]
        raise _TwiceError(next(key for key in keys if keys.count(key) > 1))
    return found


def _whole(digits: str) -> int | float:
    return int(digits) if len(digits) <= LONGEST_WHOLE else float(digits)


def _doubtful(content: object) -> bool:
    """True where something lies too deep or is not finite: level by level, as a large file has millions of values."""
    level: list[Any] = [content]
    for _ in range(DEEPEST):
        values = [value for node in level for value in (node.values() if type(node) is dict else node)]
        if not all(math.isfinite(value) for value in values if type(value) is float):
            return True
        level = [value for value in values if type(value) is dict or type(value) is list]
        if not level:
            return False
    return True


def _leaves(value: Any, place: Place) -> Iterator[tuple[Place, Any]]:
    """Every value that is no object and no list, and the first that lies too deep, with its place."""
    if isinstance(value, dict | list) and len(place) <= DEEPEST:
        for step, below in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _leaves(below, (*place, step))
    else:
        yield place, value
