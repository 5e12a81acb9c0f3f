"""Results become JSON: by field names, without loss, and never as text that other programs cannot read."""

import json
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest
from msgspec import Struct, field

from fusion.files.json_values import json_text, json_values


@dataclass(frozen=True)
class Inner:
    at: Any
    place: Path = Path("a") / "b"


class Outer(Struct, frozen=True, omit_defaults=True):
    inner: tuple[Inner, ...]
    low: float = field(name="from")
    more: Any = None


def test_fields_are_keys_and_arrays_are_lists():
    value = Outer((Inner(np.arange(4.0).reshape(2, 2)), Inner(np.float32(0.5))), 1.0)
    inner = [{"at": [[0.0, 1.0], [2.0, 3.0]], "place": "a/b"}, {"at": 0.5, "place": "a/b"}]
    assert json_values(value) == {"inner": inner, "from": 1.0}


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -np.inf, np.float32("nan"), np.full((1, 2), np.nan)])
def test_what_is_no_number_is_null_wherever_it_stands(bad):
    nothing = [[None, None]] if isinstance(bad, np.ndarray) else None
    text = json_text(Outer((Inner(bad),), 0.0, {"deep": [{"er": bad}]}))
    read = json.loads(text, parse_constant=lambda name: pytest.fail(name))
    assert read["inner"][0]["at"] == nothing and read["more"]["deep"][0]["er"] == nothing


def test_plain_values_stay_bit_for_bit():
    rng = np.random.default_rng(0)
    plain = {"a": [1, 2.5, None, True, "text", {}], "b": rng.normal(size=50).tolist(), "c": 1e-300, "d": 2**60}
    assert json_text(plain) == json.dumps(plain, indent=1)


def test_keys_are_texts():
    content = json_values({7: "a", 0.005: 1, np.int64(3): 2, "m": MappingProxyType({"x": (1,)})})
    assert content == {"7": "a", "0.005": 1, "3": 2, "m": {"x": [1]}}


def test_what_has_no_form_is_refused():
    with pytest.raises(TypeError, match="function has no form"):
        json_values({"a": test_keys_are_texts})
