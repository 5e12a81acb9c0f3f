"""Whatever stops a command at whichever file operation, its output is wholly the old result or wholly the new one."""

import hashlib
import importlib
import json
import re
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path
from types import FunctionType
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))
from cases import CASES, TABLE, Case, make_inputs, make_slow_inputs
from stopper import Ran, available, run_stopped

from fusion.files.output.claim import MARK
from fusion.files.output.staging import sweep

pytestmark = pytest.mark.skipif(not available(), reason="this system does not tell of calls (seccomp_unotify)")
HOWS = ("killed", "full", "terminated")
SHARED = {"scan_turntable"}  # one for all cases
_known: dict[str, Any] = {}  # what was computed
_true: dict[Any, Any] = {}  # by what stands for it
STATUS = {"killed": {-9}, "full": {0, 1}, "terminated": {0, 143}}


def content(path: Path) -> dict[str, str] | None:
    """What stands there, byte by byte but for times; None where nothing does."""
    if not path.exists():
        return None
    files = [path] if path.is_file() else sorted(p for p in path.rglob("*") if p.is_file() or p.is_symlink())
    return {str(p.relative_to(path)): hashlib.sha256(timeless(p.read_bytes())).hexdigest() for p in files}


def timeless(data: bytes) -> bytes:
    return re.sub(rb'"seconds": (\{[^}]*\}|[\d.e-]+)', b"", data)


@dataclass
class Place:
    """Where a case is tried: its inputs, the output, and what may stand there."""

    case: Case
    inputs: Path
    work: Path
    kept: Path  # a copy of what stood there before, if anything did
    states: list[dict[str, str] | None]  # of the output: before, and as a run makes it

    @property
    def out(self) -> Path:
        return self.work / ("out.ply" if self.case.file else "out")

    def restore(self) -> None:
        shutil.rmtree(self.work, ignore_errors=True)
        self.work.mkdir()
        if self.kept.is_dir():
            shutil.copytree(self.kept, self.out, symlinks=True)
        elif self.kept.exists():
            shutil.copy(self.kept, self.out)

    def stopped(self, number: int, how: str) -> Ran:
        self.restore()
        return run_stopped(lambda: self.case.run(self.inputs, self.out), self.work, number, how)


def prepared(case: Case, inputs: Path, folder: Path, over: bool) -> Place:
    """With an older result, to which a person has added something, or without."""
    place = Place(case, inputs, folder / "work", folder / "kept", [])
    place.restore()
    assert case.run(inputs, place.out) == 0  # also loads all modules, which a child need not do again
    if over:
        make_older(place.out)
        place.out.rename(place.kept)
    place.restore()
    place.states.append(content(place.out))
    assert case.run(inputs, place.out) == 0
    place.states.append(content(place.out))
    assert place.states[1] is not None
    assert not over or place.states[0] is not None
    return place


def make_older(out: Path) -> None:
    """Every file of a result becomes another one; one more is only in the older result, and one is a person's."""
    for path in [out] if out.is_file() else out.rglob("*"):
        if path.is_file() and path.name != MARK:
            path.write_bytes(path.read_bytes() + b"older")
    if out.is_dir():
        mark = json.loads((out / MARK).read_text())
        (out / MARK).write_text(json.dumps(mark | {"files": [*mark["files"], "former/part.json"]}))
        for name in ("former/part.json", "former/mine.txt"):
            (out / name).parent.mkdir(exist_ok=True)
            (out / name).write_text("older")


def judge(place: Place, ran: Ran, how: str) -> None:
    """One stop."""
    at = f"{how} at {len(ran.operations)}: {ran.operations[-1]}"
    state = content(place.out)
    assert state in place.states, at
    left = [path.name for path in place.work.iterdir() if path != place.out]
    assert all(name.startswith(".partial-") for name in left), (at, left)
    assert ran.status in STATUS[how], (at, ran.status, ran.said)
    if ran.status in (1, 143):
        said = [line for line in ran.said.splitlines() if not line.startswith("note:")]
        assert len(said) == 1, (at, ran.said)
        assert ("nothing was written" not in ran.said) or state == place.states[0], at
        assert how != "full" or ("disk is full" in ran.said and "out" in ran.said), at
    if how == "terminated":
        assert not left, (at, left)
    sweep(place.work)
    assert [path.name for path in place.work.iterdir() if path != place.out] == [], at
    assert content(place.out) in place.states


def every_stop(case: Case, inputs: Path, folder: Path, over: bool, how: str) -> None:
    place = prepared(case, inputs, folder, over)
    before = content(inputs)
    whole = place.stopped(0, how)
    assert whole.status == 0, whole.said
    assert content(place.out) == place.states[1]
    assert len(whole.operations) > 10
    for number in range(1, len(whole.operations) + 1, case.every):
        judge(place, place.stopped(number, how), how)
    assert content(inputs) == before


def memorise(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a case names is not computed again in the children: no file operation is a part of it."""
    for dotted in case.once:
        module, _, name = dotted.partition(":")
        owner: Any = importlib.import_module(module)
        *parents, last = name.split(".")
        for parent in parents:
            owner = getattr(owner, parent)
        own = "" if name in SHARED else f"{case.name} {case.arguments}"
        monkeypatch.setattr(owner, last, _remembered(getattr(owner, last), own + dotted))


@pytest.fixture(autouse=True)
def forgotten():
    """Modules that were loaded meanwhile have what is remembered under a name of their own: they get the true one."""
    yield
    for name, module in list(sys.modules.items()):
        for word, value in list(vars(module).items()) if name.startswith("fusion.") else ():
            if isinstance(value, FunctionType) and value in _true:
                setattr(module, word, _true[value])


def _remembered(function: Any, key: str) -> Any:
    def again(*args: Any, **more: Any) -> Any:
        if key not in _known:
            value = function(*args, **more)
            _known[key] = list(value) if hasattr(value, "__next__") else value
        return iter(_known[key]) if isinstance(_known[key], list) else _known[key]

    _true[again] = function
    return again


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("inputs").resolve()
    make_inputs(folder)
    return folder


@pytest.mark.parametrize("how", HOWS)
@pytest.mark.parametrize("over", [False, True], ids=["new", "over"])
@pytest.mark.parametrize("case", [case for case in CASES if case.quick], ids=lambda case: case.name)
def test_a_stop_at_any_operation_leaves_the_old_or_the_new(case, over, how, inputs, tmp_path, monkeypatch):
    memorise(case, monkeypatch)
    every_stop(case, inputs, tmp_path.resolve(), over, how)


@pytest.mark.parametrize("how", ["killed", "full"])
def test_the_judge_finds_a_result_that_is_not_put_in_its_place_at_once(how, inputs, tmp_path, monkeypatch):
    """A check that cannot fail would be worth nothing."""
    monkeypatch.setattr("fusion.files.output.publish.put", lambda at, place: shutil.copyfile(at.made, place))
    monkeypatch.setattr("fusion.files.output.claim.put", lambda at, place: shutil.copyfile(at.made, place))
    with pytest.raises(AssertionError, match=rf"{how} at [0-9]+"):
        every_stop(CASES[0], inputs, tmp_path.resolve(), True, how)


@pytest.fixture(scope="module")
def slow_inputs(inputs):
    """As `inputs`, with recordings; the scan is computed too, for whoever needs one."""
    make_slow_inputs(inputs)
    with pytest.MonkeyPatch.context() as monkeypatch:
        memorise(TABLE, monkeypatch)
        assert TABLE.run(inputs, inputs.parent / "scanned") == 0
    return inputs


@pytest.mark.slow
@pytest.mark.parametrize("how", HOWS)
@pytest.mark.parametrize("over", [False, True], ids=["new", "over"])
@pytest.mark.parametrize("case", [case for case in CASES if not case.quick], ids=lambda case: case.name)
def test_a_stop_of_a_long_command_does_so_too(case, over, how, slow_inputs, tmp_path, monkeypatch):
    memorise(case, monkeypatch)
    every_stop(case, slow_inputs, tmp_path.resolve(), over, how)
