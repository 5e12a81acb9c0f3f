"""Whatever two threads call at the same time, they get what they get one after the other.

tools/endurance/thread_rounds.py repeats it 100 times, in an order that is another every time.
"""

import inspect
from pathlib import Path
from tempfile import mkdtemp
from types import FunctionType
from typing import Any

import calls
import pytest
from inputs import Inputs, made
from side_by_side import compared, flat

import fusion

METHODS = (FunctionType, staticmethod, classmethod)
SEEN = Path(calls.__file__).read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("threads")
    return [made(folder / str(seed), seed) for seed in (1, 2)]


@pytest.fixture(scope="module")
def alone():
    """What calls give by themselves, see `both`: each is made once, for all tests."""
    return {}


def both(
    call: calls.Call, inputs: list[Inputs], tmp_path: Path, rounds: int, alone: dict[tuple[str, int], dict[str, Any]]
) -> list[str]:
    """What differs when each thread makes a call with inputs of its own; `alone`: by the call and its inputs' seed."""

    def once(given: Inputs):
        return call(given, Path(mkdtemp(dir=tmp_path)))

    keys = [(call.__name__, given.seed) for given in inputs]
    for key, given in zip(keys, inputs, strict=True):
        if key not in alone:
            alone[key] = flat(once(given))
    return compared(lambda: once(inputs[0]), lambda: once(inputs[1]), rounds, [alone[key] for key in keys])


@pytest.mark.parametrize("call", calls.LIGHT, ids=lambda call: call.__name__)
def test_light_calls(call, inputs, tmp_path, alone):
    assert not both(call, inputs, tmp_path, 1, alone)


@pytest.mark.slow
@pytest.mark.parametrize("call", calls.HEAVY, ids=lambda call: call.__name__)
def test_heavy_calls(call, inputs, tmp_path, alone):
    assert not both(call, inputs, tmp_path, 3, alone)


@pytest.mark.slow
def test_the_same_objects_in_both_threads(inputs, tmp_path, alone):
    """What is given may be shared: nothing of it is changed."""
    same = [inputs[0]] * 2
    wrong = {call.__name__: both(call, same, tmp_path, 2, alone) for call in calls.LIGHT + calls.HEAVY}
    assert not {name: found[:5] for name, found in wrong.items() if found}


def test_every_public_name_is_called():
    assert [name for name in fusion.__all__ if f"fusion.{name}" not in SEEN and name not in RESULTS] == []


def test_every_method_of_the_public_classes_is_called():
    missing = []
    for name in fusion.__all__:
        cls = getattr(fusion, name)
        if inspect.isclass(cls):
            methods = [
                n for n, value in vars(cls).items() if isinstance(value, FunctionType | staticmethod | classmethod)
            ]
            missing += [f"{name}.{n}" for n in methods if not n.startswith("_") and f".{n}(" not in SEEN]
    assert missing == []


# what calls give, and the error: no calls of their own
RESULTS = {
    "__version__", "Comparison", "DenseField", "Description", "Explanation", "FusionError", "Merged", "Pass",
    "Printable", "Reconstruction", "Recorded", "RecordSettings", "Recording", "Scan", "Simulation", "Source",
    "SourceFrame", "Export", "SensorComparison", "Verdict",
}  # fmt: skip
