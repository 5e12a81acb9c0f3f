"""Turntable scans with planted faults: is the first page's summary right, and silent on clean scans?

python -m tools.sets.planted_faults -o OUT    all 18 cases of the development seed
python -m tools.sets.planted_faults -o OUT --cases clean-1 slip --seed 7

Each case is rendered, scanned by `fusion turntable RECORDING -o OUT` in a process of its own, and judged from what a
user sees: exit status, terminal, settings.json ("judgement"), report.html, and the mesh against the true object. The
generator and the judge (tools/sets/planted) share no code with the package. The truth lies beside the recording, never
in it. `OUT/table.txt` and `OUT/table.json` hold what is printed. The same seed makes the same recordings.
"""

import argparse
import json
import os
import shutil
import sys
import textwrap
import time
from dataclasses import asdict
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # products of small matrices: threads would only wait

from tools.sets.planted.cases import CASES, Case
from tools.sets.planted.making import make
from tools.sets.planted.measure import measured
from tools.sets.planted.ruling import Ruling, rule
from tools.sets.planted.said import run


def main() -> int:
    """Make, scan, judge, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", nargs="+", choices=[c.name for c in CASES], help="default: all")
    parser.add_argument("--seed", type=int, default=1, help="1 is the development set")
    parser.add_argument("--keep", action="store_true", help="keep the recordings")
    parser.add_argument("-o", "--output", type=Path, required=True)
    options = parser.parse_args()
    rulings = []
    for case in CASES:
        if options.cases and case.name not in options.cases:
            continue
        rulings.append(judged(case, options.seed, options.output, options.keep))
        print(entry(rulings[-1]), flush=True)
    told = summary(rulings)
    print(told)
    (options.output / "table.txt").write_text("\n".join([*map(entry, rulings), told, ""]), encoding="utf-8")
    rows = [{"case": r.case.name, "right": r.right} | asdict(r) for r in rulings]
    (options.output / "table.json").write_text(json.dumps(rows, indent=1), encoding="utf-8")
    return 0 if all(r.right for r in rulings) else 1


def judged(case: Case, seed: int, output: Path, keep: bool = False) -> Ruling:
    """One case; an older one of the same name is made anew."""
    folder = output / case.name
    shutil.rmtree(folder, ignore_errors=True)
    begin = time.monotonic()
    make(case, seed, folder)
    print(f"{case.name}: made in {time.monotonic() - begin:.0f} s", end=", ", file=sys.stderr, flush=True)
    said = run(folder / "recording", folder / "scan")
    print(f"scanned in {said.seconds:.0f} s", file=sys.stderr, flush=True)
    (folder / "terminal.txt").write_text(said.terminal, encoding="utf-8")
    ruling = rule(case, said, measured(said.mesh, folder / "truth") if said.mesh else None)
    if not keep:
        shutil.rmtree(folder / "recording")
    return ruling


def entry(ruling: Ruling) -> str:
    """A case in some lines."""
    m = ruling.measured
    mesh = f"rms {m.rms * 1e3:.2f} mm, scale {m.scale - 1:+.2%}, covered {m.covered:.0%}" if m else "none"
    rows = {
        "planted": ruling.case.planted or "nothing",
        "expected": ruling.expected,
        "said": ruling.said,
        "mesh": mesh,
        "wrong": "; ".join(ruling.wrong) or "-",
    }
    lines = [f"{ruling.case.name}: {'right' if ruling.right else 'WRONG'}"]
    for name, text in rows.items():
        lines += textwrap.wrap(text, 130, initial_indent=f"  {name:<9}", subsequent_indent=" " * 11)
    return "\n".join(lines)


def summary(rulings: list[Ruling]) -> str:
    out = []
    for name, planted in (("clean", False), ("faults", True)):
        some = [r for r in rulings if bool(r.case.planted) == planted]
        out.append(f"{name}: {sum(r.right for r in some)} of {len(some)} right")
    return "; ".join(out)


if __name__ == "__main__":
    raise SystemExit(main())
