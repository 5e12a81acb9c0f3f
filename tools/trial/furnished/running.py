"""The command `fusion explain` on a case, in a process of its own that sees recordings and sensor.json alone."""

import json
import os
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tools.trial.engine import WHOLE

LIMIT_S = 1800


@dataclass(frozen=True)
class ExplainedCase:
    """`verdict` is None, and `complaint` holds the last words, where there was none; `seconds` of the whole command."""

    verdict: dict[str, Any] | None
    seconds: float
    complaint: str


def explained(case: Path, out: Path) -> ExplainedCase:
    """Runs the command into `out`; a verdict that is there already is kept."""
    beside = out.with_suffix(".json")  # what the folder of the engine does not hold
    verdict = out / "verdict.json"
    if beside.exists() and verdict.exists():
        seconds = json.loads(beside.read_text(encoding="utf-8"))["seconds"]
        return ExplainedCase(json.loads(verdict.read_text(encoding="utf-8")), seconds, "")
    shutil.rmtree(out, ignore_errors=True)
    out.parent.mkdir(parents=True, exist_ok=True)
    start = time.monotonic()
    complaint = _complaint(case, out)
    seconds = time.monotonic() - start
    beside.write_text(json.dumps({"seconds": seconds, "complaint": complaint}, indent=1), encoding="utf-8")
    if complaint or not verdict.exists():
        verdict.unlink(missing_ok=True)
        return ExplainedCase(None, seconds, complaint or "no verdict")
    return ExplainedCase(json.loads(verdict.read_text(encoding="utf-8")), seconds, "")


def _complaint(case: Path, out: Path) -> str:
    """What the command said when it failed, "" when it did not."""
    recordings = sorted(str(path) for path in case.glob("rec_*"))
    command = [sys.executable, "-P", "-c", WHOLE, "explain", *recordings]
    command += ["--sensor", str(case / "sensor.json"), "--no-report", "-o", str(out)]
    threads = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    environment = {**os.environ, **threads}
    if checkout := os.environ.get("FUSION_ENGINE"):  # the engine of another checkout, as in tools.trial.engine
        environment["PYTHONPATH"] = str(Path(checkout).resolve())
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S, env=environment)
    except subprocess.TimeoutExpired:
        return f"no answer within {LIMIT_S} s"
    words = " / ".join(done.stderr.strip().splitlines()[-3:]) or "failed"
    return words if done.returncode else ""
