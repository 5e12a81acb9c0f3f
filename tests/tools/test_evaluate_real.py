"""The figures of `fusion evaluate` on real recordings hold."""

import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]


@pytest.mark.real
def test_real_recordings_give_the_stated_figures(shared):
    """Noise and dip of a Kinect v2's floor, quantisation step of a Kinect v1; limits are in the tool."""
    command = [sys.executable, "-m", "tools.reproduce.evaluate_real", "--shared", shared.resolve()]
    done = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(done.stdout.splitlines()) == 5 and "!" not in done.stdout
