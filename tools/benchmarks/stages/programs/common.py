"""What every contestant's program shares; standard library and numpy only, as each runs in an environment of its own.

A program is called as `python PROGRAM WORKLOAD OUT`: it reads the workload's file and writes OUT.json (times in
seconds, memory in MiB) and, where its results are judged, OUT.npz.
"""

import gc
import json
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

RAYCAST_EVERY = 5  # frames
EXTRACTS = 3
PAIRS = 10


def load() -> SimpleNamespace:
    """The workload's arrays by name; depth stays uint16 millimetres."""
    with np.load(sys.argv[1]) as data:
        values = {name: data[name] for name in data.files}
    w = SimpleNamespace(**values)
    w.name = str(w.name)
    for name in ("voxel", "truncation", "far"):
        setattr(w, name, float(getattr(w, name)))
    return w


def answer(arrays: dict[str, Any] | None = None, **values: Any) -> None:
    """Write the results."""
    out = Path(sys.argv[2])
    if arrays:
        np.savez(out.with_suffix(".npz"), **arrays)
    out.with_suffix(".json").write_text(json.dumps(values), encoding="utf-8")


class Clock:
    """`with Clock(times): ...` appends the seconds that passed."""

    def __init__(self, times: list[float]) -> None:
        self.times = times

    def __enter__(self) -> None:
        self.start = time.perf_counter()

    def __exit__(self, *_: object) -> None:
        self.times.append(time.perf_counter() - self.start)


def memory(reset: bool = False) -> float:
    """Peak memory of this process since the last reset, or now when it resets [MiB]; 0 where Linux is not."""
    status = Path("/proc/self/status")
    if not status.exists():
        return 0.0
    if reset:
        gc.collect()
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")  # peak = now
    line = next(row for row in status.read_text(encoding="ascii").splitlines() if row.startswith("VmHWM"))
    return int(line.split()[1]) / 1024


def measure_volume(make: Any, w: SimpleNamespace, raycasts: bool = True, frames: int | None = None) -> None:
    """Fuse, see and mesh the workload with what make() returns: integrate(k), raycast(k) -> depth [m], extract()."""
    warm = make()  # kernels, threads and first pages are no part of a running scan
    for k in range(3):
        warm.integrate(k)
    if raycasts:
        warm.raycast(0)
    warm.extract()
    del warm
    before = memory(reset=True)
    volume, times = make(), {"integrate": [], "raycast": [], "extract": []}  # type: ignore[var-annotated]
    for k in range(len(w.depth[:frames])):
        with Clock(times["integrate"]):
            volume.integrate(k)
    grown, errors = memory() - before, []
    for k in range(0, len(w.depth[:frames]) if raycasts else 0, RAYCAST_EVERY):
        with Clock(times["raycast"]):
            seen = volume.raycast(k)
        truth = w.depth[k] * 1e-3
        both = np.isfinite(seen) & (seen > 0) & (truth > 0)
        errors.append((np.median(np.abs(seen - truth)[both]), both.sum() / (truth > 0).sum()))
    for _ in range(EXTRACTS):
        with Clock(times["extract"]):
            vertices, triangles = volume.extract()
    error, share = np.median(errors, axis=0) if errors else (None, None)
    answer({"vertices": vertices}, times=times, memory=grown, depth_error=error, seen=share, triangles=triangles)


def measure_align(place: Any, w: SimpleNamespace) -> None:
    """Align frame k + 1 with frame k with place(k + 1, k) -> T_k_source (4, 4), starting at no motion."""
    pairs = [(k, k + 1) for k in range(0, len(w.depth) - 1, 9)][:PAIRS]
    place(*pairs[0][::-1])
    times: list[float] = []
    errors = []
    for target, source in pairs * 2:
        with Clock(times):
            found = place(source, target)
        wrong = np.linalg.inv(np.linalg.inv(w.poses[target]) @ w.poses[source]) @ found
        cosine = np.clip((np.trace(wrong[:3, :3]) - 1) / 2, -1, 1)
        errors.append((np.linalg.norm(wrong[:3, 3]) * 1e3, np.degrees(np.arccos(cosine))))
    (shift, turn), largest = np.median(errors, axis=0), np.max(errors, axis=0)[0]
    answer(times={"align": times}, shift_mm=shift, turn_deg=turn, largest_mm=largest)
