"""Units of two sensors, each calibrated from its own boards and walls and then used to scan: how right is the scale?

    python tools/fresh_units.py -o OUT --units 40 --seed 1            20 of each sensor, statues and blocks
    python tools/fresh_units.py -o OUT --units 40 --seed 1 --only 7   one of them

A unit is drawn below the level of depth: phasors of a time-of-flight camera, dots of a structured-light one
(tools/fresh, which shares no formula with the package). Its owner calibrates the camera from 20 boards and the depth
from 6 to 10 walls that a laser has measured, scans an object on a turntable, and compares with the true object; the
commands run in processes of their own. The same scan without errors, at its true poses, is what could be reached. What
walls and boards allow at best is in tools/fresh/information.py. The truth lies in OUT/unit_NN/truth.

`OUT/table.txt` and `OUT/table.json` hold what is printed. The same seed makes the same units.
"""

import argparse
import json
import os
import shutil
import sys
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # products of small matrices: threads would only wait

import numpy as np
from fresh.judged import Judged, judged
from fresh.making import make
from fresh.table import HEAD, line, row, summary
from fresh.unit import drawn

KINDS = ("itof", "structured_light")
SHAPES = ("statue", "blocks")
BULKY = ("board", "wall_*", "scan", "clean", "measured", "compare*", "posed*", "result")


def main() -> int:
    """Make, run, judge, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--units", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, nargs="+", metavar="K", help="these units alone")
    parser.add_argument("--keep", action="store_true", help="keep recordings and results")
    parser.add_argument("--make-only", action="store_true", help="write the recordings and stop")
    parser.add_argument("--made", action="store_true", help="the recordings are there: judge them anew")
    options = parser.parse_args()
    units: list[Judged] = []
    print(HEAD, flush=True)
    for k in range(options.units) if options.only is None else options.only:
        folder = options.output / f"unit_{k:02d}"
        if not options.made:
            made(k, options.seed, folder)
        if options.make_only:
            continue
        units.append(judged(folder))
        print(line(units[-1]), flush=True)
        (folder / "judged.json").write_text(json.dumps(row(units[-1]), indent=1), encoding="utf-8")
        for bulky in () if options.keep else BULKY:
            for path in folder.glob(bulky):
                shutil.rmtree(path)
        told = summary(units)
        (options.output / "table.txt").write_text("\n".join([HEAD, *map(line, units), told, ""]), encoding="utf-8")
        (options.output / "table.json").write_text(json.dumps([row(u) for u in units], indent=1), encoding="utf-8")
    if units:
        print(summary(units))
    return 0


def made(k: int, seed: int, folder: Path) -> None:
    """Unit k: sensors take turns, and so do objects."""
    begin, rng = time.monotonic(), np.random.default_rng([seed, k])
    unit = drawn(KINDS[k % 2], SHAPES[k // 2 % 2], folder.name, rng)
    make(unit, folder, rng)
    print(f"{folder.name}: made in {time.monotonic() - begin:.0f} s", file=sys.stderr, flush=True)


if __name__ == "__main__":
    raise SystemExit(main())
