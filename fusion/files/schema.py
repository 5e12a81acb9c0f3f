"""What a JSON schema says, in words, at any place of a file: messages and published schemas have one source."""

import re
from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from functools import cache
from typing import Any

import msgspec

from fusion.files.places import Place, at

MOST_NAMES = 12  # more are not read: those like what was found are told
Node = dict[str, Any]  # a JSON schema, or a part of one


@cache
def schema_of(kind: Any) -> Node:
    """The JSON schema of a type (Structs, Annotated with Meta); not to be changed by the caller."""
    return msgspec.json.schema(kind)


def node_at(schema: Node, place: Place, content: Any) -> Node:
    """The part of a schema that speaks of a place in a file's content; empty where it says nothing."""
    node = schema
    for step in place:
        node = _below(schema, node, step, content)
        content = _value_at(content, (step,))
    return node


def expectation(schema: Node, node: Node, found: Any = None) -> str:
    """What may stand there instead of what was found: "a number from 0.002 to 0.5 (side of a square [m])"."""
    options = [option for option in _options(schema, node, None) if option.get("type") != "null"]
    # what a class says of itself is not about this place
    others = [option for option in options if "title" not in option and option.get("type") != "string"]
    meant = [node.get("description"), *(option.get("description") for option in others)]
    meaning = next(filter(None, meant), "")
    if meaning and all(option.get("type") in ("array", "object") for option in options):
        return str(meaning)  # of a shape that it tells better
    words = " or ".join(filter(None, dict.fromkeys(_words(option, found) for option in options)))
    if meaning and words != meaning:  # a unit alone needs no brackets of its own
        words = f"{words} {meaning}" if meaning.startswith("[") else f"{words} ({meaning})"
    most = max((option.get("maximum", 0) for option in options), default=0)
    # a thousand times too large for metres, and not more
    if "[m]" in meaning and isinstance(found, int | float) and most < found <= 1000 * most:
        words += f"; {found:g} looks like millimetres: write {found / 1000:g}"
    return words


def keys_at(schema: Node, place: Place, content: Any) -> list[str]:
    """The keys that the object at a place may have."""
    node = node_at(schema, place, content)
    objects = _options(schema, node, _value_at(content, place))
    return [key for option in objects for key in option.get("properties", {})]


def holds_objects(schema: Node, node: Node) -> bool:
    """True where a JSON object may stand."""
    return any(option.get("type") == "object" for option in _options(schema, node, None))


def ignored(schema: Node, content: Any) -> list[Place]:
    """Places of keys of which the schema says nothing."""
    return list(_ignored(schema, schema, content, ()))


def _ignored(schema: Node, node: Node, content: Any, place: Place) -> Iterator[Place]:
    if isinstance(content, list):
        for index, value in enumerate(content):
            yield from _ignored(schema, _below(schema, node, index, content), value, (*place, index))
    elif isinstance(content, dict):
        objects = [o for o in _options(schema, node, content) if "properties" in o]
        for key, value in content.items():
            if not objects or any(key in option["properties"] for option in objects):
                yield from _ignored(schema, _below(schema, node, key, content), value, (*place, key))
            elif key != "$schema":  # with which a file names its schema to an editor
                yield (*place, key)


def _below(schema: Node, node: Node, step: str | int, content: Any) -> Node:
    for option in _options(schema, node, content):
        tag = option.get("discriminator", {})
        if tag.get("propertyName") == step:
            return {"enum": list(tag["mapping"])}
        if isinstance(step, int):
            found = option.get("items")
        else:
            found = option.get("properties", {}).get(step) or option.get("additionalProperties")
        if isinstance(found, dict):
            return found
    return {}


def _options(schema: Node, node: Node, content: Any) -> Iterator[Node]:
    """The forms a value may have, references followed; of objects that name their kind the one that content names."""
    tag = node.get("discriminator")
    if tag:
        named = content.get(tag["propertyName"]) if isinstance(content, dict) else None
        known = tag["mapping"].get(named) if isinstance(named, str) else None
        if known:
            yield from _options(schema, {"$ref": known}, content)
        else:
            yield {"type": "object", "discriminator": tag}
    elif "$ref" in node:
        yield from _options(schema, schema["$defs"][node["$ref"].rsplit("/", 1)[-1]], content)
    elif "anyOf" in node:
        for option in node["anyOf"]:
            yield from _options(schema, option, content)
    else:
        yield node


def _value_at(content: Any, place: Place) -> Any:
    try:
        return at(content, place)
    except (KeyError, IndexError, TypeError):
        return None


def _words(option: Node, found: Any) -> str:
    if "enum" in option:
        return one_of([name for name in option["enum"] if name != ""], found)
    kind = {"string": "a text", "boolean": "true or false", "array": "a list", "object": "a JSON object"}
    if option.get("type") == "string" and "description" in option:
        return str(option["description"])
    if option.get("required"):
        return "a JSON object with " + ", ".join(f'"{key}"' for key in option["required"])
    if option.get("type") in kind:
        return kind[option["type"]]
    whole = option.get("type") == "integer" or option.get("multipleOf") == 1
    return ("a whole number" if whole else "a number") + _bounds(option)


def one_of(names: Sequence[str], found: Any) -> str:
    """Which names are known, in one short line: of many those that are like what was found."""
    quoted = [f'"{name}"' for name in names]
    if len(names) <= MOST_NAMES:
        return quoted[0] if len(names) == 1 else "one of " + ", ".join(quoted)
    near = get_close_matches(str(found)[:60], names, 3, 0.4) or names[:3]
    return f"one of {len(names)} names, such as " + ", ".join(f'"{name}"' for name in near)


def _bounds(option: Node) -> str:
    low, high = option.get("minimum"), option.get("maximum")
    if low is not None and high is not None:
        return f" from {_short(low)} to {_short(high)}"
    words = [f"{name} {_short(option[key])}" for key, name in _BOUNDS.items() if key in option]
    return " " + ", ".join(words) if words else ""


def _short(number: float) -> str:
    """1e6 rather than 1e+06."""
    return re.sub(r"e\+?(-?)0*", r"e\1", f"{number:g}")


_BOUNDS = {"minimum": "of at least", "exclusiveMinimum": "above", "maximum": "up to", "exclusiveMaximum": "below"}
