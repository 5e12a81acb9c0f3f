"""Content of a JSON file as a value of a type; what does not fit is told in one sentence.

The types are msgspec's: Structs with `Annotated[float, Meta(gt=0, description="focal length [px]")]`. Bounds and words
stand there only: messages, documentation and JSON schemas are made of them. `Meta(pattern=...)` is not to be used:
msgspec 0.22 frees the pattern twice, and Python crashes at its end; say it in `extra_json_schema` and look yourself.
"""

import re
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar

import msgspec
from msgspec import Meta

from fusion.errors import FusionError
from fusion.files.json_file import shown
from fusion.files.places import Place, at, place_words
from fusion.files.schema import Node, expectation, holds_objects, ignored, keys_at, node_at, schema_of

FARTHEST_M = 1e7  # of a place: the coordinates of any map on Earth

Name = Annotated[str | int | None, Meta(description="for people")]
Whole = Annotated[float, Meta(multiple_of=1)]  # a float: 640.0 is a whole number in JSON
FileName = Annotated[str, Meta(min_length=1, description="a file's name")]
Metres = Annotated[float, Meta(gt=-FARTHEST_M, lt=FARTHEST_M)]
Point = Annotated[tuple[Metres, Metres, Metres], Meta(description="three numbers [m], below 1e7")]
_Row = tuple[Metres, Metres, Metres, Metres]
Rigid = Annotated[tuple[_Row, _Row, _Row, _Row], Meta(description="a rigid 4x4 matrix, metres, below 1e7")]


T = TypeVar("T")

_MESSAGE = re.compile(r"(?P<text>.*?)(?: - at `(?:key` in `)?\$(?P<path>.*)`)?", re.DOTALL)
_STEP = re.compile(r"\.(?P<key>[^.\[\]]+)|\[(?P<index>\d+)\]|(?P<any>\[\.\.\.\])")
_FIELD = re.compile(r"Object (?P<how>missing required|contains unknown) field `(?P<field>.*)`", re.DOTALL)
_NOTHING = object()


@dataclass(frozen=True)
class Content:
    """A JSON value, and how it is named in messages."""

    value: Any  # as `read_json` gives it
    where: object  # the file
    of: str = "the file"  # whose fields they are: "the camera"
    error: type[FusionError] = FusionError  # the kind of error to raise
    do: str = ""  # what the user can do about a wrong value

    def as_type(self, kind: type[T]) -> T:
        """The value as one of this type. Raises `error`: what is wrong at which key, what was found and expected."""
        try:
            return msgspec.convert(self.value, kind, strict=True)
        except msgspec.ValidationError as problem:
            raise self._told(str(problem), kind) from problem

    def wrong(self, kind: Any, *place: str | int, expected: str = "", found: str = "") -> FusionError:
        """The error of a value that fits the type and still cannot be used; expected is what the type says."""
        value = _found(self.value, place)
        seen = found or ("nothing" if value is _NOTHING else shown(value))
        schema = schema_of(kind)
        must = expected or expectation(schema, node_at(schema, place, self.value), value)
        name = place_words(place, self.value)
        what = f"{name} of {self.of}" if name else self.of
        return self.error(f"{what} cannot be used", self.where, seen, must, self.do)

    def unknown(self, kind: Any, besides: str = "") -> list[str]:
        """A sentence for each key that the type does not know, `besides` what stands under that key."""
        places = [place for place in ignored(schema_of(kind), self.value) if besides not in place[:1]]
        return [f"{self.where}: {place_words(place, self.value)} is not known and ignored" for place in places]

    def _told(self, message: str, kind: Any) -> FusionError:
        """The error behind a message of msgspec, such as "Expected `float` >= 0 - at `$.parts[3].reflectance`"."""
        match = _MESSAGE.fullmatch(message)
        assert match is not None  # any text fits
        place = self._place(match["path"] or "", message, kind)
        field = _FIELD.fullmatch(match["text"])
        if field:
            place = (*place, field["field"])
        if field and field["how"] == "contains unknown":
            return self._unknown_field(place, kind)
        return self.wrong(kind, *_whole_lists(place, schema_of(kind), self.value))

    def _place(self, path: str, message: str, kind: Any) -> Place:
        """msgspec's path as keys and positions; it does not say which key of a dict: that is tried."""
        place: Place = ()
        for step in _STEP.finditer(path):
            if step["any"]:
                place = (*place, self._culprit(place, message, kind))
            else:
                place = (*place, step["key"] if step["index"] is None else int(step["index"]))
        return place

    def _culprit(self, place: Place, message: str, kind: Any) -> str:
        keys = list(at(self.value, place))
        for key in keys:
            try:
                msgspec.convert(_only(self.value, place, key), kind, strict=True)
            except msgspec.ValidationError as problem:
                if str(problem) == message:
                    return str(key)
        return str(keys[0])

    def _unknown_field(self, place: Place, kind: Any) -> FusionError:
        names = ", ".join(keys_at(schema_of(kind), place[:-1], self.value))
        what = f"{place_words(place, self.value)} of {self.of} is not known"
        return self.error(what, self.where, shown(place[-1]), f"one of {names}" if names else "no key", self.do)


def _found(value: Any, place: Place) -> Any:
    try:
        return at(value, place)
    except (KeyError, IndexError, TypeError):
        return _NOTHING


def _only(value: Any, place: Place, key: str) -> Any:
    """The content with one key alone in the object at a place."""
    if not place:
        return {key: value[key]}
    step, *rest = place
    changed = dict(value) if isinstance(value, dict) else list(value)
    changed[step] = _only(value[step], tuple(rest), key)  # type: ignore[index]
    return changed


def _whole_lists(place: Place, schema: Node, value: Any) -> Place:
    """The place without positions in lists of numbers: such a list is told as a whole."""
    for depth, step in enumerate(place):
        if isinstance(step, int) and not holds_objects(schema, node_at(schema, place[: depth + 1], value)):
            return place[:depth]
    return place
