"""What each kernel takes of fusing a frame and of seeing it: wall and processor time, medians.

python -m tools.benchmarks.kernels [--workload object room] [--frames 25] [--cache out/benchmark/cache]
"""

import argparse
import os
import time
from collections import defaultdict
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from fusion.compute.launch import Kernel
from fusion.compute.process import tune_process
from fusion.compute.start import start
from fusion.geometry.camera import Camera
from fusion.volume.volume import Volume, VolumeSettings
from tools.benchmarks.stages.workloads import made

Times = dict[str, list[tuple[float, float]]]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--workload", nargs="+", choices=("object", "room"), default=["object", "room"])
    parser.add_argument("--frames", type=int, default=25)
    parser.add_argument("--cache", type=Path, default=Path("out/benchmark/cache"), help="workloads of benchmark.py")
    options = parser.parse_args()
    tune_process()
    for work in options.workload:
        print(f"{work:22s}{'wall':>9s}{'processor':>11s}  [ms]")
        for name, taken in measure(made(work, options.cache), options.frames).items():
            wall, processor = (1e3 * median(column) for column in zip(*taken, strict=True))
            print(f"{name:22s}{wall:9.2f}{processor:11.2f}")
    print(f"load of the machine at the end: {os.getloadavg()[0]:.1f}")


def measure(path: Path, frames: int) -> Times:
    """Wall and processor times [s] of kernels and of the whole, frames of a workload fused and seen in turn."""
    with np.load(path) as data:
        w = {name: data[name] for name in data.files}
    K, T, far = w["K"], w["poses"], float(w["far"])
    camera = Camera(640, 480, K[0, 0], K[1, 1], K[0, 2], K[1, 2])
    depth = [np.where(d > 0, d * np.float32(1e-3), np.float32(np.nan)) for d in w["depth"]]
    volume = Volume(VolumeSettings(float(w["voxel"]), float(w["truncation"])))
    for k in range(len(T)):
        volume.integrate(depth[k], camera, T[k])
    volume.raycast(camera, T[0], far=far)
    times = _listened()
    for k in (7 * n % len(T) for n in range(frames)):
        began = _clock()
        volume.integrate(depth[k], camera, T[k])
        between = _clock()
        volume.raycast(camera, T[k], far=far)
        times["integrate, whole"].append(_since(began, between))
        times["raycast, whole"].append(_since(between, _clock()))
    return times


def _listened() -> Times:
    """Times of kernels from now on, by name; rays are cast in steps of several pixels."""
    start()
    times: Times = defaultdict(list)
    called = getattr(Kernel.__call__, "plain", Kernel.__call__)

    def call(kernel: Kernel, *args: Any) -> Any:
        began, out = _clock(), called(kernel, *args)
        name = kernel.name
        times[f"  {name}, step {args[0]}" if name == "cast" else f"  {name}"].append(_since(began, _clock()))
        return out

    call.plain = called  # type: ignore[attr-defined]
    Kernel.__call__ = call  # type: ignore
    return times


def _clock() -> tuple[float, float]:
    return time.perf_counter(), time.process_time()


def _since(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
    return b[0] - a[0], b[1] - a[1]


if __name__ == "__main__":
    main()
