"""The engine as a separate process, on a folder that holds no label."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

LIMIT_S = 600
WHOLE = "import sys; from fusion.commands.main import main; sys.exit(main())"
HERE = Path(__file__).resolve().parent
# as the program sets up its process, which has to be before anything else of fusion is imported
TUNED = (
    "import runpy, sys; from fusion.compute.process import tune_process; tune_process(); "
    "sys.argv = sys.argv[1:]; runpy.run_path(sys.argv[0], run_name='__main__')"
)
ENGINE = ("-P", "-c", TUNED, str(HERE / "engine_side.py"))


def explained(
    case: Path, out: Path, whole: bool = False, without: Sequence[str] = ()
) -> tuple[dict[str, Any] | None, float, str]:
    """The verdict, None when there was none; seconds; its last lines of complaint.

    Args:
        case: folder with recordings and sensor.json.
        out: where the engine writes.
        whole: run the command with its report, not the verdict alone.
        without: names of effects that the engine does not have; not with the whole command.
    """
    recordings = sorted(str(p) for p in case.glob("rec_*"))
    program = ["-P", "-c", WHOLE, "explain"] if whole and not without else [*ENGINE, "explain"]
    command = [*program, *recordings, "--sensor", str(case / "sensor.json"), "-o", str(out)]
    command += ["--without", *without] if without else []
    seconds, complaint = _run(command)
    file = out / "verdict.json"
    verdict = json.loads(file.read_text(encoding="utf-8")) if file.is_file() and not complaint else None
    return verdict, seconds, complaint


def predicted(recordings: Path, sensors: list[Path], scratch: Path) -> NDArray[np.float64] | None:
    """(sensors, recordings, h, w) [m] depth of recordings that the engine was not given, by its models, or None."""
    paths = sorted(str(p) for p in recordings.glob("rec_*"))
    file = scratch / "predicted.npy"
    words = [*ENGINE, "predict", *paths, "--sensor", *map(str, sensors), "-o", str(file)]
    _, complaint = _run(words)
    return None if complaint else np.asarray(np.load(file))


def naively(case: Path, out: Path) -> dict[str, list[str]]:
    """Names that plainer methods claim, the first first; {} when they fail."""
    recordings = sorted(str(p) for p in case.glob("rec_*"))
    words = [str(HERE / "naive.py"), *recordings, "--sensor", str(case / "sensor.json"), "-o", str(out)]
    _, complaint = _run(words)
    return {"failed": [complaint]} if complaint else dict(json.loads(out.read_text(encoding="utf-8")))


def _other() -> dict[str, str]:
    """What makes Python find another checkout's engine, which the variable FUSION_ENGINE names."""
    checkout = os.environ.get("FUSION_ENGINE")
    return {"PYTHONPATH": str(Path(checkout).resolve())} if checkout else {}


def _run(words: list[str]) -> tuple[float, str]:
    """Seconds, and the last lines of complaint of a Python program that failed."""
    threads = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    start = time.monotonic()
    try:
        done = subprocess.run(
            [sys.executable, *words],
            capture_output=True,
            text=True,
            timeout=LIMIT_S,
            env={**os.environ, **threads, **_other()},
        )
        complaint = " / ".join(done.stderr.strip().splitlines()[-3:]) or "failed" if done.returncode else ""
    except subprocess.TimeoutExpired:
        complaint = f"no answer within {LIMIT_S} s"
    return time.monotonic() - start, complaint
