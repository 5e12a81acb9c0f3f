"""Content of a JSON file as a type: what does not fit is told with its key, what was found, and what the type says."""

from typing import Annotated, Literal

import pytest
from msgspec import Meta, Struct

from fusion.errors import RecordingError
from fusion.files.content import Content
from fusion.files.schema import schema_of

Side = Annotated[float, Meta(gt=0, le=2, description="side [m]")]


class Leaf(Struct, frozen=True, kw_only=True, tag_field="effect", tag="leaf", forbid_unknown_fields=True):
    size: Side
    color: Literal["red", "green"] = "red"


class Stem(Struct, frozen=True, kw_only=True, tag_field="effect", tag="stem"):
    place: Annotated[tuple[float, float], Meta(description="two numbers [m]")] | None = None


class Plant(Struct, frozen=True, kw_only=True):
    name: str
    count: Annotated[float, Meta(ge=1, le=9, multiple_of=1)] = 1
    effects: list[Leaf | Stem] = []
    std: dict[str, Annotated[float, Meta(ge=0)]] = {}
    pot: Stem | str | None = None


def refusal(**fields) -> str:
    with pytest.raises(RecordingError) as caught:
        Content({"name": "n"} | fields, "plant.json", "the plant", RecordingError, "water it").as_type(Plant)
    return str(caught.value)


WRONG = [
    ({"name": 3}, '"name" of the plant cannot be used; in plant.json; found 3; expected a text; water it'),
    ({"count": 1.5}, '"count" of the plant cannot be used; in plant.json; found 1.5; expected a whole number from 1'),
    ({"count": True}, "found true; expected a whole number from 1 to 9"),
    ({"std": {"a": 1, "b": -1}}, '"std.b" of the plant cannot be used; in plant.json; found -1; expected a number'),
    ({"std": {"a": 1, "b": "x"}}, "\"std.b\" of the plant cannot be used; in plant.json; found 'x'"),
    ({"std": 3}, '"std" of the plant cannot be used; in plant.json; found 3; expected a JSON object'),
    ({"effects": [{}]}, '"effect" of effect 1 of the plant cannot be used; in plant.json; found nothing; expected one'),
    ({"effects": [{"effect": "root"}]}, 'found \'root\'; expected one of "leaf", "stem"'),
    ({"effects": [3]}, "effect 1 of the plant cannot be used; in plant.json; found 3; expected a JSON object"),
    ({"effects": [{"effect": "leaf"}]}, '"size" of effect leaf of the plant cannot be used; in plant.json; found noth'),
    ({"effects": [{"effect": "leaf", "size": 0}]}, "found 0; expected a number above 0, up to 2 (side [m])"),
    ({"effects": [{"effect": "leaf", "size": 300}]}, "300 looks like millimetres: write 0.3"),
    ({"effects": [{"effect": "leaf", "size": 1, "color": "x"}]}, 'expected one of "green", "red"'),
    ({"effects": [{"effect": "leaf", "size": 1, "x": 1}]}, '"x" of effect leaf of the plant is not known'),
    ({"effects": [{"effect": "leaf", "size": 1, "x": 1}]}, "found 'x'; expected one of effect, size, color"),
    ({"effects": [{"effect": "stem", "place": [1, "2"]}]}, "found [1, '2']; expected two numbers [m]"),
    ({"effects": [{"effect": "stem", "place": [1, "2"]}]}, '"place" of effect stem of the plant cannot be used'),
    ({"pot": {"effect": "stem", "place": 1}}, '"pot.place" of the plant cannot be used'),
]


@pytest.mark.parametrize(("fields", "said"), WRONG, ids=[str(fields)[:50] for fields, _ in WRONG])
def test_a_wrong_value_is_told_with_key_finding_and_expectation(fields, said):
    assert said in refusal(**fields)


def test_what_is_no_object_is_told():
    with pytest.raises(RecordingError, match=r"the plant cannot be used; in x; found \[\]; expected a JSON obj"):
        Content([], "x", "the plant", RecordingError).as_type(Plant)


def test_good_content_is_read_and_unknown_keys_are_told_where_asked():
    value = {"name": "n", "count": 3.0, "effects": [{"effect": "stem", "new": 1}], "std": {"any": 2}, "more": {"a": 1}}
    content = Content(value, "x.json")
    plant = content.as_type(Plant)
    assert plant.count == 3 and plant.effects == [Stem()] and plant.std == {"any": 2}
    assert content.unknown(Plant) == [
        'x.json: "new" of effect stem is not known and ignored',
        'x.json: "more" is not known and ignored',
    ]


def test_the_schema_of_a_type_is_not_changed_by_messages():
    before = repr(schema_of(Plant))
    refusal(count=0)
    assert repr(schema_of(Plant)) == before
