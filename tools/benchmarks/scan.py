"""Where the time of a whole turntable scan goes: 180 frames of 640 x 480 px, simulated once and kept.

    OPENBLAS_NUM_THREADS=1 python -m tools.benchmarks.scan [--recording FOLDER] [--runs 3]

(one thread for small systems, as the command line sets it)

Asked: post-pass (axis, angles, closed loop, against the model) and integration of all frames below 10 s on two cores.
Other programs on the machine lengthen wall time, so the time that two free cores would take stands beside it: the
processor time of the main thread, and half of what the kernels' threads take while it waits. The first run compiles
what is not cached and is not counted.
"""

import argparse
import statistics
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fusion.compute.process import tune_process
from fusion.recording.open import open_recording
from fusion.scan import making, placing
from fusion.scan.finding import attempt, turn
from fusion.scan.pipeline import scan_turntable
from fusion.scan.settings import ScanSettings
from fusion.sensor.files.sensor_file import read_sensor
from fusion.simulation.demo.demo import write_demo_recording

ASKED_S = 10.0
FRAMES = 180
STAGES = {  # what the pipeline calls: the stage it belongs to
    (attempt, "find_region"): "what turns",
    (attempt, "load"): "load and prepare",
    (attempt, "fit_pairs"): "pairs",
    (turn, "fit_model"): "model",
    (making, "fused"): "integrate",
    (placing, "track_freely"): "free tracking",
    (making, "clean"): "clean up",
}
POST_PASS = ("pairs", "model", "integrate")
CLOCKS = (time.perf_counter, time.process_time, time.thread_time)

Times = dict[str, list[float]]


def timed(function: Callable[..., Any], stage: str, spent: Times) -> Callable[..., Any]:
    """The function, its wall time, processor time and that of the main thread [s] added to a stage."""

    def run(*args: Any, **named: Any) -> Any:
        before = [clock() for clock in CLOCKS]
        try:
            return function(*args, **named)
        finally:
            for k, clock in enumerate(CLOCKS):
                spent[stage][k] += clock() - before[k]

    return run


def measure(folder: Path) -> Times:
    """Wall time, processor time and that of the main thread [s] of each stage of one scan."""
    spent: Times = defaultdict(lambda: [0.0, 0.0, 0.0])
    kept = {place: getattr(*place) for place in STAGES}
    try:
        for (module, name), stage in STAGES.items():
            setattr(module, name, timed(kept[module, name], stage, spent))
        settings = ScanSettings(sensor=read_sensor(folder / "sensor.json"))
        timed(scan_turntable, "whole scan", spent)(open_recording(folder / "recording"), settings)
    finally:
        for (module, name), function in kept.items():
            setattr(module, name, function)
    return dict(spent)


def main() -> int:
    tune_process()
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--recording", type=Path, help="made there where it is not yet (default: a temporary folder)")
    parser.add_argument("--runs", type=int, default=3)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = options.recording or Path(name)
        if not (folder / "recording" / "camera.json").exists():
            write_demo_recording(folder, frames=FRAMES)
        measure(folder)
        runs = [measure(folder) for _ in range(options.runs)]
    for stage in runs[0]:
        wall, processor, free = (statistics.median(k) for k in zip(*(_shown(run[stage]) for run in runs), strict=True))
        print(f"{stage:18} {wall:7.2f} s {processor:7.2f} s of processor {free:7.2f} s on two free cores")
    post, free = (statistics.median(sum(_shown(run[s])[k] for s in POST_PASS) for run in runs) for k in (0, 2))
    print(f"post-pass and integration: {post:.2f} s, {free:.2f} s on two free cores (asked {ASKED_S:.0f} s)")
    return 0 if post < ASKED_S else 1


def _shown(times: list[float]) -> tuple[float, float, float]:
    """Wall and processor time, and the time on two cores that nobody else uses [s]."""
    wall, processor, alone = times
    return wall, processor, (processor + alone) / 2


if __name__ == "__main__":
    raise SystemExit(main())
