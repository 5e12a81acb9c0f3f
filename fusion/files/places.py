"""Places in the content of a JSON file, in words of a person."""

from typing import Any

Place = tuple[str | int, ...]  # keys and, in lists, positions from 0


def at(content: Any, place: Place) -> Any:
    """The value at a place; KeyError, IndexError or TypeError where there is none."""
    for step in place:
        content = content[step]
    return content


def place_words(place: Place, content: Any) -> str:
    """A place as a person would say it: `"fx"`, `"std.fx"`, `"pose.eye" of part 2`, `"unit" of effect depth_offset`.

    Positions count from 1; an object that names itself (`{"effect": "depth_offset"}` in `"effects"`) is called so.
    """
    parts: list[str] = []  # outermost first
    keys: list[str] = []
    for depth, step in enumerate(place):
        if isinstance(step, str):
            keys.append(step)
            continue
        if not keys:  # a list in a list
            parts.append(f"{step + 1}")
            continue
        kind = keys.pop().removesuffix("s")
        parts += [_quoted(keys)] if keys else []
        parts.append(f"{kind} {_own_name(content, place[: depth + 1], kind) or step + 1}")
        keys = []
    parts += [_quoted(keys)] if keys else []
    return " of ".join(reversed(parts))


def _quoted(keys: list[str]) -> str:
    text = ".".join(keys)
    return f'"{text[:60]}"'


def _own_name(content: Any, place: Place, kind: str) -> str:
    try:
        name = at(content, (*place, kind))
    except (KeyError, IndexError, TypeError):
        return ""
    return name[:40] if isinstance(name, str) else ""
