"""How the time of a frame grows with frames, voxels, pixels, turns and cores, as a table and a picture.

python -m tools.benchmarks.growth [--frames 10000] [--law frames voxel ...] [--out out/growth]
"""

import argparse
import json
import os
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from textwrap import wrap

from fusion.compute.process import tune_process
from tools.benchmarks.stages.growth import Growth, by_cores, by_frames, by_pixels, by_turns, by_voxel
from tools.benchmarks.stages.workloads import made

LAWS = ("frames", "voxel", "pixels", "turns", "cores")


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--frames", type=int, default=10_000)
    parser.add_argument("--law", nargs="+", choices=LAWS, default=list(LAWS))
    parser.add_argument("--out", type=Path, default=Path("out/growth"))
    parser.add_argument("--cache", type=Path, default=Path("out/benchmark/cache"), help="workloads of benchmark.py")
    options = parser.parse_args()
    tune_process()
    options.out.mkdir(parents=True, exist_ok=True)
    item, room = (made(name, options.cache) for name in ("object", "room"))
    measures: dict[str, Callable[[], list[Growth]]] = {
        "frames": lambda: list(by_frames(item, options.frames)),
        "voxel": lambda: [by_voxel(item)],
        "pixels": lambda: [by_pixels(item)],
        "turns": lambda: [by_turns(item)],
        "cores": lambda: [by_cores(room)],
    }
    found = [growth for law in options.law for growth in measures[law]()]
    for g in found:
        print(f"{g.name:8s} {'ok ' if g.good else 'NOT'} {g.verdict}")
        if len(g.x) <= 4:
            pairs = zip(g.x, g.y, strict=True)
            print("         " + ", ".join(f"{x:g}: {y:.2f}" for x, y in pairs) + f"  ({g.x_label}: {g.y_label})")
    (options.out / "growth.json").write_text(json.dumps([asdict(g) for g in found], indent=1), encoding="utf-8")
    draw(found, options.out / "growth.png")
    print(f"load of the machine at the end: {os.getloadavg()[0]:.1f}; files in {options.out}")
    return 0 if all(g.good for g in found) else 1


def draw(found: list[Growth], path: Path) -> None:
    """One panel a law."""
    from matplotlib.figure import Figure

    from fusion.report.kit import palette

    with palette.styled():
        figure = Figure(figsize=(10, 2.9 * -(-len(found) // 3)), layout="constrained")
        grid = figure.subplots(-(-len(found) // 3), 3, squeeze=False).ravel()
        for ax, g in zip(grid, found, strict=False):
            ax.plot(g.x, g.y, marker="o" if len(g.x) < 10 else "", color=palette.BLUE if g.good else palette.ORANGE)
            if g.name in ("voxel", "pixels"):
                ax.set_xscale("log")
                ax.set_yscale("log")
                ax.set_xticks(g.x, [f"{x:g}" for x in g.x], minor=False)
                ax.set_yticks(g.y, [f"{y:.1f}" for y in g.y], minor=False)
                ax.minorticks_off()
            else:
                ax.set_ylim(0, max(g.y) * 1.2)
            ax.set_title(g.name)
            ax.set_xlabel("\n".join([g.x_label, *wrap(g.verdict, 34)]))
            ax.set_ylabel(g.y_label)
        for ax in grid[len(found) :]:
            ax.remove()
        figure.savefig(path, facecolor="white", dpi=110)


if __name__ == "__main__":
    raise SystemExit(main())
