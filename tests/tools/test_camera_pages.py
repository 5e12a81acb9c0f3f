"""The gallery of cameras says what the models say."""

import subprocess
import sys
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
TOOL = [sys.executable, "-m", "tools.documentation.cameras"]


def test_committed_texts_are_up_to_date():
    done = subprocess.run([*TOOL, "--check"], cwd=PROJECT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{done.stdout}{done.stderr}"


def test_pictures_are_small():
    sizes = [path.stat().st_size for path in (PROJECT / "docs" / "cameras").glob("*.svg")]
    assert len(sizes) > 10 and max(sizes) < 40_000
