"""The engine as a separate process, on a folder that holds no label."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

LIMIT_S = 600
WHOLE = "import sys; from fusion.commands.main import main; sys.exit(main())"
# the verdict without pictures: most of the command's time is the report
BRIEF = """
import json, sys
from pathlib import Path
from fusion.discrepancy.explain import explain
from fusion.discrepancy.verdict.verdict import verdict_of
from fusion.recording.open import open_recording
from fusion.sensor.file import read_sensor
recordings, (_, sensor, _, out) = sys.argv[2:-4], sys.argv[-4:]
verdict = verdict_of(explain([open_recording(path) for path in recordings], read_sensor(sensor)))
Path(out).mkdir(parents=True, exist_ok=True)
(Path(out) / "verdict.json").write_text(json.dumps(verdict, indent=1))
"""


def explained(case: Path, out: Path, whole: bool = False) -> tuple[dict[str, Any] | None, float, str]:
    """The verdict, None when there was none; seconds; its last lines of complaint.

    Args:
        case: folder with recordings and sensor.json.
        out: where the engine writes.
        whole: run the command with its report, not the verdict alone.
    """
    recordings = sorted(str(p) for p in case.glob("rec_*"))
    command = [sys.executable, "-c", WHOLE if whole else BRIEF, "explain", *recordings]
    command += ["--sensor", str(case / "sensor.json"), "-o", str(out)]
    threads = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    start = time.monotonic()
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S, env={**os.environ, **threads})
        complaint = " / ".join(done.stderr.strip().splitlines()[-3:]) if done.returncode else ""
    except subprocess.TimeoutExpired:
        complaint = f"no answer within {LIMIT_S} s"
    file = out / "verdict.json"
    verdict = json.loads(file.read_text(encoding="utf-8")) if file.is_file() and not complaint else None
    return verdict, time.monotonic() - start, complaint
