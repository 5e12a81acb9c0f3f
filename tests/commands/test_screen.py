"""A person who waits sees how far it is, to the last second; a log gets few lines, who asks for quiet none."""

import io
import sys
import time

import pytest

from fusion.commands.terminal import screen
from fusion.progress import each, note, seconds, stage


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def work() -> None:
    note("compiling")
    for _ in each(range(3), "tracking"):
        with stage("model", 5):
            time.sleep(0.02)
    with stage("report"):
        time.sleep(0.05)
    sys.stderr.write("the result")  # stdout and stderr are one on a terminal


@pytest.fixture
def shown(monkeypatch):
    """Runs the work and gives what stderr got."""

    def run(stream: io.StringIO, quiet: bool = False) -> str:
        monkeypatch.setattr(sys, "stderr", stream)
        monkeypatch.setattr(screen, "DRAWN", 0.005)
        with screen.showing(quiet):
            work()
        return stream.getvalue()

    return run


def test_a_terminal_shows_every_stage_and_is_clean_afterwards(shown):
    drawn = shown(Terminal())
    pictures = drawn.replace("\n", "\r").split("\r")
    assert "compiling" in drawn
    assert any("tracking" in p and "1/3" in p and "model 0 of 5" in p for p in pictures)
    assert any(p.startswith("report") for p in pictures)
    assert not pictures[-2].strip(), "the line is wiped"
    assert pictures[-1] == "the result"


def test_a_short_run_leaves_no_line_in_a_log(shown):
    assert shown(io.StringIO()) == "the result"


def test_a_long_run_leaves_a_plain_line_now_and_then_in_a_log(shown, monkeypatch):
    monkeypatch.setattr(screen, "LOGGED", 0.015)
    lines = shown(io.StringIO()).splitlines()
    assert lines[0] == "compiling"
    assert any(line.endswith("s  tracking: model 0 of 5") for line in lines)
    assert lines[-2].endswith("s  report")
    assert not any("\r" in line or "\x1b" in line for line in lines)


@pytest.mark.parametrize("stream", [Terminal, io.StringIO])
def test_quiet_is_quiet_and_still_counts(shown, monkeypatch, stream):
    monkeypatch.setattr(screen, "LOGGED", 0.0)
    assert shown(stream(), quiet=True) == "the result"
    with screen.showing(quiet=True):
        work()
        assert list(seconds()) == ["tracking", "report", "other"]


def test_the_end_says_how_long_what_took():
    assert (
        screen.took({"reading": 3.2, "motion": 9.1, "tiny": 0.02, "other": 1.0}) == "13 s: reading 3, motion 9, other 1"
    )
    assert screen.took({"reading": 0.21, "planning": 0.04, "other": 0.1}) == "0.3 s: reading 0.2, other 0.1"
