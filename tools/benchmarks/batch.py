"""How long a batch takes beside the same commands one after the other, and what a job costs beside its command.

    python -m tools.benchmarks.batch [--jobs 40] [--workers 2] [COMMAND ...]

As a user meets both: `fusion COMMAND` in a process of its own for each of some small simulated recordings, half of
them before and half after one `fusion batch` of them all, so that others on the machine disturb both alike. `{rec}` and
`{out}` stand in COMMAND as for `fusion batch`; the usual one is `evaluate {rec} -o {out} --no-report`. The load
of the machine is told: with more programs than cores both share what is left.
"""

import argparse
import csv
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import fusion
from fusion.simulation.scenes import built_in
from fusion.simulation.simulate import simulate
from fusion.simulation.write import write_simulation

FUSION = [sys.executable, "-c", "import sys; from fusion.commands.console import run; sys.exit(run())"]
USUAL = ["evaluate", "{rec}", "-o", "{out}", "--no-report"]
CAMERA = fusion.Camera(160, 120, 131.0, 131.0, 79.5, 59.5)
FRAMES = 12


def ran(words: list[str], home: Path) -> float:
    """Seconds that a command took; stops where it fails."""
    begun = time.perf_counter()
    subprocess.run([*FUSION, *words], cwd=home, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return time.perf_counter() - begun


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=40)
    parser.add_argument("--workers", type=int, default=2)
    options, words = parser.parse_known_args()
    words = words or USUAL
    with tempfile.TemporaryDirectory() as folder:
        home, sensor = Path(folder), fusion.read_sensor("kinect-v1")
        wall = built_in("wall", {"distance_m": 1.0, "frames": FRAMES})
        for number in range(options.jobs):
            made = simulate(replace(wall, camera=CAMERA), sensor, seed=number)
            write_simulation(home / "recs" / f"r{number:03d}", made)
        names = [f"r{number:03d}" for number in range(options.jobs)]
        fill = [[word.format(rec=f"recs/{name}", out=f"alone_{name}") for word in words] for name in names]
        ran(fill[0], home)  # what is cached once on a machine
        load, half = os.getloadavg()[0], options.jobs // 2
        alone = [ran([*one, "--overwrite"], home) for one in fill[:half]]
        together = ran(["batch", "recs", "-o", "out", "--workers", str(options.workers), "--", *words], home)
        alone += [ran(one, home) for one in fill[half:]]
        with (home / "out" / "timings.csv").open(newline="") as file:
            rows = list(csv.DictReader(file))
        beside = [float(row["job_s"]) - float(row["command_s"]) for row in rows]
        # the rows are in the order of the list, and so are jobs begun: the first of each worker starts its process
        first = {row["worker"]: place for place, row in reversed(list(enumerate(rows)))}.values()
        beside = [seconds for place, seconds in enumerate(beside) if place not in first]
    print(
        f"{options.jobs} jobs of {' '.join(words)}; load {load:.1f} to {os.getloadavg()[0]:.1f}, {os.cpu_count()} cores"
    )
    row = sum(alone)
    print(f"one after the other {row:.1f} s, {options.workers} workers {together:.1f} s: {together / row:.2f}")
    told = f"{np.median(beside):.3f} s in the median, {max(beside):.3f} s at most"
    print(f"a job beside its command, but for each worker's first: {told}")


if __name__ == "__main__":
    main()
