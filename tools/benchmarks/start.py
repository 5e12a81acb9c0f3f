"""How soon something happens: the help, the import, and the first frame of a run whose kernels are cached.

    python -m tools.benchmarks.start [--rounds 9]

Each figure is the least wall time of some runs, each a fresh process, from its start until it says that it is done;
and the least processor time of the whole process: what it would take on a machine that does nothing else. The first
frame is there when a frame of 640 x 480 px is prepared, fused and seen again, as in `fusion reconstruct`. Python's
compiled files are kept from run to run as the kernels are, whatever PYTHONDONTWRITEBYTECODE says.
"""

import argparse
import os
import subprocess
import sys
import time

FIRST_FRAME = """
from fusion.compute.process import tune_process

tune_process()
import numpy as np
from fusion.geometry.camera import Camera
from fusion.recording.recording import Frame
from fusion.sensor.presets import default_sensor
from fusion.volume.prepared import fuse, prepare
from fusion.volume.volume import Volume, VolumeSettings

camera = Camera(640, 480, 570.0, 570.0, 319.5, 239.5)
volume = Volume(VolumeSettings(0.004, 0.016))
depth = np.full(camera.shape, 0.9, np.float32)
depth[:, 320:] = 1.2  # an edge, as every real frame has
frame = Frame(0, 0.0, depth)
fuse(volume, prepare(frame, camera, default_sensor(camera)), np.eye(4))
assert np.isfinite(volume.raycast(camera, np.eye(4)).depth).any()
"""
HELP = """
from fusion.commands.main import main

try:
    main(["--help"])
except SystemExit:
    pass
"""
DONE = "done, says the program"
ASKED = {  # program and seconds
    "fusion --help": (HELP, 0.5),
    "import fusion": ("import fusion", 0.2),
    "first frame, kernels cached": (FIRST_FRAME, 1.5),
}


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--rounds", type=int, default=9)
    options = parser.parse_args()
    programs = {"the interpreter alone": ("pass", 0.1), **ASKED}
    good = True
    for name, (program, asked) in programs.items():
        _seconds(program)  # compiles and caches
        wall, processor = (min(k) for k in zip(*(_seconds(program) for _ in range(options.rounds)), strict=True))
        good &= wall <= asked
        verdict = "ok" if wall <= asked else "NOT"
        print(f"{name:30s}{wall:6.2f} s, asked {asked:g}  {verdict}  ({processor:.2f} s of processor)")
    print(f"load of the machine: {os.getloadavg()[0]:.1f}")
    return 0 if good else 1


def _seconds(program: str) -> tuple[float, float]:
    """Wall and processor time of a program [s]."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    start, before = time.perf_counter(), os.times()
    command = [sys.executable, "-c", f"{program}\nprint({DONE!r}, flush=True)"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout is not None
        done = next((time.perf_counter() for line in process.stdout if line.strip() == DONE), None)
        process.stdout.read()
    if process.returncode or done is None:
        raise SystemExit(f"a program of the benchmark stopped with exit status {process.returncode}")
    after = os.times()
    used = after.children_user + after.children_system - before.children_user - before.children_system
    return done - start, used


if __name__ == "__main__":
    raise SystemExit(main())
