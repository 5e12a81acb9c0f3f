"""Open one recording in a process of its own: seconds, memory, frames a second. Prints one JSON object.

python -m tools.formats.opening PATH CAMERA|- FRAMES    FRAMES: how many are read, spread over the recording
"""

import json
import sys
import time
from pathlib import Path

import numpy as np

import fusion


def memory_mb(name: str) -> float:
    """VmRSS: what is resident now; VmHWM: the largest since `Path("/proc/self/clear_refs")` was told 5 [MB]. Linux."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(name)) / 1024


def main() -> None:
    """Open, then read."""
    path, said, count = sys.argv[1], sys.argv[2], int(sys.argv[3])
    fusion.open_recording  # noqa: B018 (the name is loaded when it is first asked for)
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    before, begin, wall = memory_mb("VmRSS"), time.process_time(), time.monotonic()
    recording = fusion.open_recording(path, None if said == "-" else said)
    told = {"frames": len(recording), "cpu_s": time.process_time() - begin, "wall_s": time.monotonic() - wall}
    told |= {"open_mb": memory_mb("VmHWM") - before, "poses": recording.poses is not None}
    wanted = np.unique(np.linspace(0, len(recording) - 1, count).round().astype(int)).tolist()
    recording[wanted[-1]]  # what comes once, such as a kernel that is loaded
    begin = time.process_time()
    for index in wanted:
        recording[index]
    told |= {"rate": len(wanted) / max(time.process_time() - begin, 1e-9), "all_mb": memory_mb("VmHWM") - before}
    print(json.dumps(told))


if __name__ == "__main__":
    main()
