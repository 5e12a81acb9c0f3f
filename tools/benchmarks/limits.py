"""How far integrate and raycast are from what memory alone would allow.

    python -m tools.benchmarks.limits [--repeats 40]

Bytes are those that must move once: the depth image, every row of eight voxels that the frame changes (read and
written), and what a raycast writes. The bandwidth is that of reading, changing and writing 256 MiB, which
no cache holds. Times are the least processor time of many repeats on one frame, shared by two cores: other
programs on the machine disturb it less than wall time.
"""

import argparse
import os
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from fusion.compute.process import tune_process
from fusion.compute.start import start
from fusion.volume.volume import Volume, VolumeSettings
from tools.benchmarks.stages.growth import Views
from tools.benchmarks.stages.workloads import WORKLOADS, made

FRAME = 40
ROW = 2 * 8 * 4  # bytes of eight voxels: sums of weight * distance and of weight
SEEN = 7 * 4  # bytes that a raycast writes per pixel: depth, point, normal
MEMORY = 1 << 26  # values, 256 MiB


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--repeats", type=int, default=40)
    parser.add_argument("--cache", type=Path, default=Path("out/benchmark/cache"), help="workloads of benchmark.py")
    options = parser.parse_args()
    tune_process()
    start()
    rate = bandwidth()
    print(f"memory, read and written: {rate * 1e-6:.1f} GB/s")
    for name, w in WORKLOADS.items():
        views = Views.of(made(name, options.cache))
        volume = Volume(VolumeSettings(w.voxel, w.truncation))
        for k in range(0, len(views.depth), 3):
            views.fuse(volume, k)
        rows, blocks = changed(views, volume)
        pixels, pose = views.depth[0].size, views.poses[FRAME]
        fuse = partial(views.fuse, volume, FRAME)
        see = partial(volume.raycast, views.camera, pose, far=w.far)
        report("integrate", name, rows * ROW * 2 + pixels * 4, rate, least(fuse, options.repeats))
        report("raycast", name, pixels * SEEN + rows * ROW, rate, least(see, options.repeats))
        print(f"                  {blocks} blocks, {rows} rows of eight voxels change")
    print(f"load of the machine at the end: {os.getloadavg()[0]:.1f}")


def bandwidth() -> float:
    """Bytes per ms that two cores read, change and write, at twice the best of one."""
    block, best = np.ones(MEMORY, np.float32), 0.0
    for _ in range(8):
        begun = time.process_time()
        block += 1.0
        best = max(best, 2 * block.nbytes / (time.process_time() - begun) * 1e-3)
    return 2 * best


def changed(views: Views, volume: Volume) -> tuple[int, int]:
    """Rows and blocks that one more look at the frame changes."""
    views.fuse(volume, FRAME)
    before = volume.blocks.voxels[: volume.block_count, :, 1].copy()
    views.fuse(volume, FRAME)
    rows = (volume.blocks.voxels[: volume.block_count, :, 1] != before).any(axis=2)
    return int(rows.sum()), int(rows.any(axis=1).sum())


def least(work: Callable[[], object], repeats: int) -> float:
    """Processor time of two cores [ms]."""
    times = []
    for _ in range(repeats):
        begun = time.process_time()
        work()
        times.append(time.process_time() - begun)
    return min(times) * 1e3 / 2


def report(stage: str, name: str, moved: int, rate: float, taken: float) -> None:
    """One line; the rate is in bytes per ms."""
    floor = moved / rate
    times = f"{floor:5.2f} ms at least, {taken:6.2f} ms taken, {taken / floor:.0f} times"
    print(f"{stage:10s}{name:8s}{moved / 2**20:6.1f} MiB: {times}")


if __name__ == "__main__":
    main()
