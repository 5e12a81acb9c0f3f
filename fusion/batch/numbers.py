"""The numbers of a result, whatever command made it: what its JSON files say, by name."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from fusion.errors import FusionError
from fusion.files.json_file import read_json

# files that state what was given, and not what came out, but for these of their keys
GIVEN = {"settings": ("result", "agreement", "judgement")}
DEEPEST = 6
FEW = 8  # entries of a list that are numbers of the result; longer ones are curves, or there is one for each frame
LONGEST = 200  # characters of a text
MOST = 1000  # numbers of one result
LIGHTS = ("good", "doubtful", "failed")

Value = float | int | bool | str


def numbers_in(folder: Path) -> dict[str, Value]:
    """`file.key.key` to number, text or truth value, of the JSON files in a folder; short lists by place."""
    found: dict[str, Value] = {}
    for path in sorted(folder.glob("*.json")):
        if path.name.startswith("."):
            continue
        try:
            content: Mapping[str, Any] = read_json(path)
        except FusionError:
            continue
        if path.stem in GIVEN:
            content = {key: content[key] for key in GIVEN[path.stem] if key in content}
        for name, value in _flat(content, path.stem):
            if len(found) < MOST:
                found[name] = value
    return found


def light_of(folder: Path) -> tuple[str, str]:
    """The verdict of a result in one word, and its worst reason; "done" where nothing is judged."""
    if not folder.is_dir():
        return "done", ""
    for name in ("turntable.json", "merge.json", "settings.json"):
        try:
            content = read_json(folder / name)
        except FusionError:
            continue
        for holder in (content, content.get("judgement")):
            if isinstance(holder, dict) and holder.get("verdict") in LIGHTS:
                reasons = holder.get("reasons")
                first = reasons[0] if isinstance(reasons, list) and reasons else ""
                return str(holder["verdict"]), str(first) if holder["verdict"] != "good" else ""
    return "done", ""


def unread_in(numbers: Mapping[str, Value]) -> str:
    """What a result says of frames that could not be read, in a sentence; "" where all were."""
    lost = sum(int(value) for name, value in numbers.items() if name.endswith(".frames_unreadable"))
    return f"{lost} frame{'s' * (lost > 1)} could not be read" if lost else ""


def _flat(content: Mapping[str, Any], before: str, depth: int = 0) -> Iterator[tuple[str, Value]]:
    for key, value in content.items():
        name = f"{before}.{key}"
        if isinstance(value, list) and len(value) <= FEW:
            value = {str(place): entry for place, entry in enumerate(value)}
        if isinstance(value, dict) and depth < DEEPEST:
            yield from _flat(value, name, depth + 1)
        elif isinstance(value, bool | int | float) or (isinstance(value, str) and len(value) <= LONGEST):
            yield name, value
