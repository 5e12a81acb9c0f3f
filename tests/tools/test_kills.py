"""The tool that kills commands at random moments: it finds nothing lost, and would find it."""

import subprocess
import sys
from pathlib import Path

import pytest

from tools.endurance import kills

PROJECT = Path(__file__).resolve().parents[2]

# writes its files in their place, one after the other
CARELESS = """
import pathlib, time
for name in "ab":
    pathlib.Path("try/out", name).write_text("new")
    time.sleep(20)
"""


@pytest.mark.slow
def test_nothing_is_lost():
    command = [sys.executable, "tools/endurance/kills.py", "--kills", "10", "--seed", "7"]
    done = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "10 kills, 0 lost" in done.stdout


def test_what_is_lost_is_found(tmp_path, monkeypatch):
    """A careless run leaves a mixture of old and new."""
    monkeypatch.setattr(kills, "START", CARELESS)
    monkeypatch.setitem(kills.COMMANDS, "try", "OUT")
    (tmp_path / "try" / "kept").mkdir(parents=True)
    for name in "ab":
        (tmp_path / "try" / "kept" / name).write_text("old")
    result = {name: kills._digest(b"new") for name in "ab"}
    one = kills.Tried("try", 2.0, result, repeatable=True)
    kills._kill(tmp_path, one, kills.SIGNALS[0], 0.9, over=True)
    assert one.lost
