"""How soon something happens: the help, the import, and the first frame of a run whose kernels are cached.

    python tools/benchmark_start.py [--rounds 5]

Each figure is the least wall time of some runs, each a fresh process. The first frame is timed from the start of the
process until a 640 x 480 frame is prepared, fused and seen again, as in `fusion reconstruct`.
"""

import argparse
import os
import subprocess
import sys
import time

FIRST_FRAME = """
import numpy as np
from fusion.geometry.camera import Camera
from fusion.recording.recording import Frame
from fusion.sensor.presets import default_sensor
from fusion.volume.prepared import fuse, prepare
from fusion.volume.volume import Volume, VolumeSettings

camera = Camera(640, 480, 570.0, 570.0, 319.5, 239.5)
volume = Volume(VolumeSettings(0.004, 0.016))
frame = Frame(0, 0.0, np.full(camera.shape, 0.9, np.float32))
fuse(volume, prepare(frame, camera, default_sensor(camera)), np.eye(4))
assert np.isfinite(volume.raycast(camera, np.eye(4)).depth).any()
"""
ASKED = {  # name, program, seconds
    "fusion --help": ("from fusion.commands.main import main; main(['--help'])", 0.5),
    "import fusion": ("import fusion", 0.2),
    "first frame, kernels cached": (FIRST_FRAME, 1.5),
}


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    interpreter = min(_seconds("pass") for _ in range(options.rounds))
    print(f"{'the interpreter alone':30s}{interpreter:6.2f} s")
    good = True
    for name, (program, asked) in ASKED.items():
        _seconds(program)  # compiles and caches
        found = min(_seconds(program) for _ in range(options.rounds))
        good &= found <= asked
        print(f"{name:30s}{found:6.2f} s, asked {asked:g}  {'ok' if found <= asked else 'NOT'}")
    print(f"load of the machine: {os.getloadavg()[0]:.1f}")
    return 0 if good else 1


def _seconds(program: str) -> float:
    start = time.perf_counter()
    subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, timeout=120)
    return time.perf_counter() - start


if __name__ == "__main__":
    raise SystemExit(main())
