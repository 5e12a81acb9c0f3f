"""The examples run as a person runs them, in a folder of their own, without a warning."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
EXAMPLES = sorted((PROJECT / "examples").glob("*.py"))
NEEDS = {"05_batch": "distributed"}
LONGEST = 240  # [s]: each promises less than a minute, and other programs may run beside it


def test_they_are_numbered_and_told():
    assert [int(path.name[:2]) for path in EXAMPLES] == list(range(1, len(EXAMPLES) + 1))
    for path in EXAMPLES:
        # a heading, its line, and words, as the site needs them
        assert re.match(r'"""\n(.+)\n=+\n\n\S', path.read_text(encoding="utf-8")), path.name


def test_an_effect_of_ones_own_takes_thirty_lines():
    text = (PROJECT / "examples" / "02_own_effect.py").read_text(encoding="utf-8")
    program = text.partition('"""\n\n')[2].partition("# %%")[0]
    assert len(program.strip().splitlines()) <= 30


@pytest.mark.slow
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_it_runs(path, tmp_path):
    if path.stem in NEEDS:
        pytest.importorskip(NEEDS[path.stem], reason="comes with the extra batch")
    environment = os.environ | {"MPLBACKEND": "agg", "TMPDIR": str(tmp_path), "PYTHONPATH": str(PROJECT)}
    command = [sys.executable, "-W", "error::UserWarning", path]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=LONGEST)
    assert done.returncode == 0, done.stderr
    assert "Warning" not in done.stderr
