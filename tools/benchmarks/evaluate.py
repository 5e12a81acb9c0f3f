"""Time and memory of `fusion evaluate` as a user meets them: the whole command, reading and report included.

    python -m tools.benchmarks.evaluate [--frames 100 400] [--color]

A still wall of 640 x 480 px, depth and IR (and colour) with noise in every pixel, so that the PNG are as large as real
ones. Asked: below 5 s for 100 frames, and a memory that does not depend on their number.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fusion.geometry.camera import Camera, Principle
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording

CAMERA = Camera(
    640, 480, 525.0, 525.0, 319.5, 239.5, depth_scale=1000, principle=Principle.TIME_OF_FLIGHT, sensor="benchmark"
)
ASKED_S = 5.0


def frames(count: int, color: bool) -> Iterator[Frame]:
    """A wall with a slope, 3 mm of noise."""
    rng = np.random.default_rng(0)
    v, u = np.mgrid[0:480, 0:640]
    wall = (1.5 + 0.2 * (u - 320) / 640).astype(np.float32)
    for i in range(count):
        depth = wall + np.float32(0.003) * rng.standard_normal(wall.shape, dtype=np.float32)
        ir = (2000 + 1000 * np.cos(v / 200) + 40 * rng.standard_normal(wall.shape)).astype(np.uint16)
        rgb = rng.integers(100, 120, (*wall.shape, 3), dtype=np.uint8) if color else None
        yield Frame(i, i / 30, depth, rgb, ir)


def run(folder: Path, out: Path) -> tuple[float, float, float]:
    """Wall time [s], processor time [s] and peak memory [MB] of the command in a process of its own."""
    program = "import sys; from fusion.commands.main import main; sys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-c", program, "evaluate", str(folder), "-o", str(out), "--overwrite"]
    start = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"the command failed: {status}")
    return time.perf_counter() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, nargs="+", default=[100, 400])
    parser.add_argument("--color", action="store_true")
    options = parser.parse_args()
    good = True
    with tempfile.TemporaryDirectory() as name:
        for count in options.frames:
            folder = Path(name) / f"wall_{count}"
            write_recording(folder, CAMERA, frames(count, options.color), telemetry=_distance())
            seconds, busy, memory = run(folder, Path(name) / f"out_{count}")
            asked = " (asked 5 s)" if count == 100 else ""
            print(f"{count} frames: {seconds:.2f} s{asked}, {busy:.2f} s of processor, {memory:.0f} MB")
            good &= count != 100 or seconds < ASKED_S
    return 0 if good else 1


def _distance() -> dict[str, list[float]]:
    return {"timestamp": [0.0, 1e3], "distance_m": [1.5, 1.5]}


if __name__ == "__main__":
    sys.exit(main())
