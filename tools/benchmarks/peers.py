"""Every stage of fusion against every peer that can be installed: the same work, in turn, several times.

    python -m tools.benchmarks.peers [--stage integrate raycast ...] [--workload object room] [--peers] [--rounds 3]
                                     [--kernels quadrants ...] [--out out/benchmark]

Writes benchmark.json and one picture per stage. Times are medians over the frames; the spread is that of the rounds.
Peers run in environments of their own, made below OUT/cache on the first run. Open3D's legacy ScalableTSDFVolume is
left out, as it stays empty in 0.20, and so is OpenCV's KinFu, which its builds refuse to make.
"""

import argparse
import json
import os
from dataclasses import asdict
from pathlib import Path

from tools.benchmarks.stages.asked import ASKED, PARTS, QUOTED, STAGES
from tools.benchmarks.stages.contest import CONTESTANTS, OURS, beside, contest
from tools.benchmarks.stages.judge import query
from tools.benchmarks.stages.table import Row, Table, draw, table, text
from tools.benchmarks.stages.workloads import made


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument(
        "--stage", nargs="+", choices=STAGES, default=list(STAGES), metavar="STAGE", help=" ".join(STAGES)
    )
    parser.add_argument("--workload", nargs="+", choices=("object", "room"), default=["object", "room"])
    parser.add_argument("--peers", action="store_true", help="run the peers too")
    parser.add_argument("--kernels", nargs="+", default=[], help="run ours on these, too: what FUSION_KERNELS may say")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--out", type=Path, default=Path("out/benchmark"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    tables = [t for work in [*options.workload, "points"] for t in _tables(work, options)]
    if options.peers:
        tables = _with_sums(tables)
    for stage in dict.fromkeys(t.stage for t in tables):
        draw([t for t in tables if t.stage == stage], options.out / f"{stage}.png")
    found = [{**asdict(t), "ratio": t.ratio} for t in tables]
    (options.out / "benchmark.json").write_text(json.dumps(found, indent=1), encoding="utf-8")
    for t in tables:
        print(text(t))
        for row in t.rows:
            if "did not run" in row.note and row.name in QUOTED:
                print(f"  {row.name} on another machine with two cores: {QUOTED[row.name]}")
    print(f"load of the machine at the end: {os.getloadavg()[0]:.1f}; files in {options.out}")


def _tables(work: str, options: argparse.Namespace) -> list[Table]:
    stages = [s for s in options.stage if (s, work) in ASKED]
    if not stages:
        return []
    cache = options.out / "cache"
    path = query(cache) if work == "points" else made(work, cache)
    every = [
        *(c for c in CONTESTANTS if options.peers or c.name == OURS),
        *(b for k in options.kernels for b in beside(k)),
    ]
    chosen = [c for c in every if set(c.stages) & set(stages)]
    scores = contest(chosen, path, cache, options.rounds)
    return [table(stage, work, scores) for stage in stages]


def _with_sums(tables: list[Table]) -> list[Table]:
    """Updates get a peer: the best integration, raycast and alignment of this run added up."""
    out = []
    for t in tables:
        parts = [p for p in tables if p.workload == t.workload and p.stage in PARTS]
        if t.stage == "update" and len(parts) == len(PARTS):
            best = sum(p.best for p in parts)
            peer = Row("sum of the best parts", best, best, best, "not run as one")
            t = Table(t.stage, t.workload, t.unit, (*t.rows, peer), t.asked, t.complaints)
        out.append(t)
    return out


if __name__ == "__main__":
    main()
