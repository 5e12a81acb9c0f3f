"""The figures of `fusion evaluate` on real recordings hold."""

import subprocess
import sys
from pathlib import Path

import pytest

TOOL = Path(__file__).resolve().parents[2] / "tools" / "evaluate_real.py"


@pytest.mark.real
def test_real_recordings_give_the_stated_figures(shared):
    """Noise and dip of a Kinect v2's floor, quantisation step of a Kinect v1; limits are in the tool."""
    done = subprocess.run([sys.executable, TOOL, "--shared", shared], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(done.stdout.splitlines()) == 5 and "!" not in done.stdout
