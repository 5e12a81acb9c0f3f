"""The judge sees what it should: each way of breaking the rule, and nothing in a run that keeps it."""

import os
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from broken.case import ACCEPTED, EITHER, REFUSED, TOLD, Case
from broken.judge import TOO_MUCH, judged
from broken.runner import LIMIT_BYTES, LIMIT_S, Ran
from broken.server import follow

LINE = b"fusion info: an image is damaged; in rec/depth/000000.png; found no image data; copy the file again\n"
REFUSING = Case("a case", lambda folder: [], REFUSED, ("000000.png",))


def ran(folder: Path, **changed: object) -> Ran:
    """A run that refuses as it should, with some of it changed."""
    kept = Ran(
        words=["reconstruct", "rec", "-o", "out"],
        status=1,
        stdout=b"",
        stderr=LINE,
        seconds=1.0,
        cpu=1.0,
        peak=10**8,
        ended="",
        events=[],
        before={"rec/a": "file 1"},
        after={"rec/a": "file 1"},
        folder=folder,
        scratch=[],
        read_outside=[],
    )
    return replace(kept, **changed)  # type: ignore[arg-type]


def test_a_run_that_keeps_the_rule(tmp_path):
    assert judged(REFUSING, ran(tmp_path)) == []
    assert judged(REFUSING, ran(tmp_path, stderr=b"   5 s  looking\n" + LINE)) == []


@pytest.mark.parametrize(
    ("changed", "kind"),
    [
        ({"status": 0}, "accepted"),
        ({"status": -11}, "crash"),
        ({"status": 70}, "crash"),
        ({"stderr": LINE + LINE}, "lines"),
        ({"stderr": b""}, "lines"),
        ({"stderr": b"sorry: 000000.png\n"}, "line does not begin"),
        ({"stderr": b"fusion info: something is wrong\n"}, "where"),
        ({"stderr": LINE.strip() + b"x" * 700 + b"\n"}, "long"),
        ({"stderr": LINE.replace(b"an image", b"\x1b[31man image")}, "control"),
        ({"stderr": LINE.replace(b"an image", "an \u202e image".encode())}, "control"),
        ({"stderr": LINE.replace(b"an image", b"\xff")}, "letters"),
        ({"stderr": b"Traceback (most recent call last):\n" + LINE}, "foreign"),
        ({"stderr": b"libpng error: Not enough image data\n" + LINE}, "foreign"),
        ({"stdout": b"[Open3D WARNING] Not enough correspondences\n"}, "foreign"),
        ({"stderr": b"x.py:1: RuntimeWarning: overflow\n" + LINE}, "foreign"),
        ({"ended": "time", "seconds": 45.0}, "time: 45 s"),
        ({"cpu": LIMIT_S + 1}, TOO_MUCH),
        ({"peak": LIMIT_BYTES + 1}, "memory"),
        ({"after": {"rec/a": "file 2"}}, "files"),
        ({"after": {}}, "files"),
        ({"after": {"rec/a": "file 1", "out": "folder"}}, "files"),
        ({"after": {"rec/a": "file 1", ".partial-1": "folder"}}, "files"),
        ({"scratch": ["tmp1"]}, "files"),
        ({"events": ["socket.connect"]}, "reaches out"),
        ({"read_outside": ["outside/a"]}, "reaches out"),
        ({"stderr": LINE.replace(b"no image data", b"OUTSIDE-SECRET")}, "reaches out"),
    ],
)
def test_each_way_to_break_it(changed, kind, tmp_path):
    assert any(wrong.startswith(kind) for wrong in judged(REFUSING, ran(tmp_path, **changed)))


def test_results_are_looked_at(tmp_path):
    good = {"status": 0, "stderr": b""}
    case = replace(REFUSING, expected=ACCEPTED)
    assert judged(case, ran(tmp_path, **good)) == []
    assert judged(case, ran(tmp_path))[0].startswith("refused")
    assert judged(replace(case, expected=EITHER), ran(tmp_path)) == []
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "a.json").write_text('{"a": NaN}', encoding="utf-8")
    after = {"rec/a": "file 1", "out": "folder", "out/a.json": "file 3"}
    assert judged(case, ran(tmp_path, **good, after=after))[0].startswith("nonsense")
    (tmp_path / "out" / "a.json").write_text('{"a": "root:x:0:0"}', encoding="utf-8")
    assert judged(case, ran(tmp_path, **good, after=after))[0].startswith("reaches out")
    assert judged(replace(case, look=lambda folder, text: "wrong"), ran(tmp_path, **good)) == ["nonsense: wrong"]


def test_what_is_left_out_is_told(tmp_path):
    case = replace(REFUSING, expected=TOLD)
    assert judged(case, ran(tmp_path, status=0, stderr=b""))[0].startswith("silent")
    assert judged(case, ran(tmp_path, status=0, stderr=b"", stdout=b"note: 000000.png was left out\n")) == []


def _followed(program: str, **limits: float) -> dict:
    """What becomes of a child that runs a program."""
    pid = os.posix_spawn(sys.executable, [sys.executable, "-S", "-c", program], dict(os.environ))
    return follow(pid, {"limit_s": 20.0, "idle_s": 20.0, "limit_bytes": 10**12, **limits})


def test_a_child_is_ended_where_it_waits_or_swells():
    assert _followed("raise SystemExit(3)")["status"] == 3
    assert _followed("import time; time.sleep(20)", idle_s=0.5)["ended"] == "time"
    assert _followed("while True: pass", limit_s=0.5)["ended"] == "time"
    assert (
        _followed("import time; x = b'x' * 300_000_000; time.sleep(20)", limit_bytes=250_000_000)["ended"] == "memory"
    )
