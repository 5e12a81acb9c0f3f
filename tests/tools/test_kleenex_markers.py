"""The stickers on the kleenex turntable's disc: one full turn in 23 steps, known without any tracker."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

PROJECT = Path(__file__).resolve().parents[2]
TOOL = [sys.executable, "-m", "tools.reproduce.scans.kleenex_markers"]


def run(*options: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*TOOL, *map(str, options)], cwd=PROJECT, capture_output=True, text=True, check=False)


@pytest.mark.real
@pytest.mark.parametrize("focal", [(), ("--focal", 525)])
def test_stickers_tell_the_turn(shared, focal):
    found = json.loads(run("--shared", shared, "--json", *focal).stdout)
    # the sticker with the black strip is the same one at the start and at the end: no whole quarter turn is miscounted
    assert found["black_strip_on_stickers"] == [3]
    assert {0, 22} <= set(found["black_strip_seen_in_frames"])
    # 1.2 deg = 3 standard errors at the nominal focal length, where the fit is worst; 14.4 deg a step would be 317
    assert found["total_deg"] == pytest.approx(342.8, abs=1.2)
    assert found["rms_px"] < 1.0 and found["sightings"] > 60
    # uneven beyond what the sightings can explain (0.4 deg a step)
    assert found["step_std_deg"] > 1.0 > 2 * np.median(found["steps_se_deg"])


def test_no_recording_is_one_clear_line(tmp_path):
    done = run("--shared", tmp_path)
    assert done.returncode == 1 and done.stderr.startswith("error: no recording") and "Traceback" not in done.stderr
