"""How the time of a frame grows: with frames, voxels, pixels, turns of the table and cores.

Processor time is taken where cores do not matter: other programs on the machine disturb it less. Each figure is the
least of a few repeats for the same reason.
"""

import os
import subprocess
import sys
import time
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.volume.volume import Volume, VolumeSettings
from tools.benchmarks.stages.contest import PROGRAMS

BAND = 4  # voxels of truncation


@dataclass(frozen=True)
class Growth:
    """One law: what is turned, what is measured, its unit, and what is asked of it."""

    name: str
    x: list[float]
    y: list[float]
    x_label: str
    y_label: str
    verdict: str
    good: bool


@dataclass(frozen=True)
class Views:
    """Depth images [m], poses and camera of a workload, every step-th pixel."""

    depth: list[NDArray[np.float32]]
    poses: NDArray[np.float64]
    camera: Camera

    @classmethod
    def of(cls, path: Path, step: int = 1) -> "Views":
        with np.load(path) as data:
            counts, poses, K = data["depth"][:, ::step, ::step], data["poses"], data["K"]
        depth = [np.where(d > 0, d * np.float32(1e-3), np.float32(np.nan)) for d in counts]
        height, width = depth[0].shape
        focal, centre = K[0, 0] / step, (K[:2, 2] / step).tolist()  # pixel (0, 0) stays where it is
        return cls(depth, poses, Camera(width, height, focal, focal, *centre))

    def fuse(self, volume: Volume, k: int) -> float:
        """Processor time [ms] of frame k, counted round and round."""
        n = k % len(self.depth)
        start = time.process_time()
        volume.integrate(self.depth[n], self.camera, self.poses[n])
        return (time.process_time() - start) * 1e3


def by_frames(path: Path, count: int) -> tuple[Growth, Growth]:
    """Small images over many frames: time and memory stay."""
    views, volume = Views.of(path, 4), Volume(VolumeSettings(0.004, 0.016))
    part = max(count // 50, 1)
    times, memory = [], []
    for start in range(0, count, part):
        times.append(float(np.median([views.fuse(volume, k) for k in range(start, min(start + part, count))])))
        memory.append(_resident())
    at = [float(n) for n in np.arange(len(times)) * part]
    settled = len(times) // 10  # the first turn makes blocks
    drift = float(np.median(times[-10:]) / np.median(times[settled : settled + 10]))
    grown = memory[-1] - memory[settled]
    said = f"last over first {drift:.2f}, asked 1.2", f"grown by {grown:.1f} MiB, asked 5"
    return (
        Growth("frames", at, times, "frame", "processor time [ms]", said[0], drift < 1.2),
        Growth("memory", at, memory, "frame", "memory [MiB]", said[1], grown < 5),
    )


def by_voxel(path: Path) -> Growth:
    """Halving the voxel multiplies the seen surface's blocks by four."""
    views, sizes = Views.of(path), [0.008, 0.004, 0.002, 0.001]
    times = [_settled(views, Volume(VolumeSettings(voxel, BAND * voxel))) for voxel in sizes]
    worst = max(b / a for a, b in pairwise(times))
    said = f"a halving costs at most {worst:.1f}, asked 4.5"
    return Growth("voxel", [v * 1e3 for v in sizes], times, "voxel [mm]", "processor time [ms]", said, worst <= 4.5)


def by_pixels(path: Path) -> Growth:
    """More pixels of the same scene: at most in proportion."""
    pixels, times = [], []
    for step in (4, 2, 1):
        views = Views.of(path, step)
        pixels.append(float(views.depth[0].size))
        times.append(_settled(views, Volume(VolumeSettings(0.002, 0.008))))
    power = float(np.polyfit(np.log(pixels), np.log(times), 1)[0])
    said = f"grows as pixels to the power {power:.2f}, asked 1.05"
    return Growth("pixels", pixels, times, "pixels", "processor time [ms]", said, power <= 1.05)


def by_turns(path: Path, turns: int = 3) -> Growth:
    """Another turn of the table sees what is known: no turn costs more than the first."""
    views, volume = Views.of(path), Volume(VolumeSettings(0.002, 0.008))
    count, times, blocks = len(views.depth), [], []
    for turn in range(turns):
        times.append(float(np.median([views.fuse(volume, turn * count + k) for k in range(count)])))
        blocks.append(volume.block_count)
    last, more = times[-1] / times[0], blocks[-1] / blocks[0]
    said = f"last over first {last:.2f}, asked 1.2; blocks {more:.3f}"
    x = [float(n) for n in range(1, turns + 1)]
    return Growth("turns", x, times, "turn", "processor time [ms]", said, last <= 1.2 and more < 1.01)


def by_cores(path: Path, rounds: int = 6) -> Growth:
    """Least wall time of integrate and raycast with one core, with two, and of two programs side by side with one each:
    what the machine itself gains by its second core, which others use at times. In turn, each in a process of its own.
    """
    best = dict.fromkeys(((1, 1), (2, 1), (1, 2)), np.inf)  # threads, programs
    for n in range(rounds):
        for setup in best if n % 2 == 0 else reversed(best):
            best[setup] = min(best[setup], _together(path, *setup))
    alone, both, beside = best.values()
    gain = alone / both
    said = f"two cores are {gain:.2f} times as fast, asked 1.8; two programs beside each other {2 * alone / beside:.2f}"
    return Growth("cores", [1.0, 2.0], [alone, both], "cores", "integrate + raycast [ms]", said, gain >= 1.8)


def _together(path: Path, threads: int, programs: int) -> float:
    """Mean of what programs that run at the same time say [ms]."""
    environment = {**os.environ, "TI_CPU_MAX_NUM_THREADS": str(threads)}
    command = [sys.executable, str(PROGRAMS / "fusion_cores.py"), str(path)]
    running = [subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) for _ in range(programs)]
    said = [process.communicate()[0] for process in running]
    if any(process.returncode for process in running):
        raise SystemExit("the program that counts cores did not run")
    return float(np.mean([float(text.split()[-1]) for text in said]))


def _settled(views: Views, volume: Volume) -> float:
    """Time of a frame of a volume that has seen a part of the circle: least of five looks, mean over four frames."""
    for k in range(0, len(views.depth), 4):
        views.fuse(volume, k)
    chosen = range(0, len(views.depth), len(views.depth) // 4)
    return float(np.mean([min(views.fuse(volume, k) for _ in range(5)) for k in chosen]))


def _resident() -> float:
    """Memory of this process now [MiB]; 0 where Linux is not."""
    try:
        text = Path("/proc/self/status").read_text(encoding="ascii")
    except OSError:
        return 0.0
    return int(next(row for row in text.splitlines() if row.startswith("VmRSS")).split()[1]) / 1024
