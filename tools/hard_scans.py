"""The hard set: is what comes of a turntable scan good, and does the scan know it?

    python tools/hard_scans.py -o OUT --scans 60 --seed 1                 the set that is reported
    python tools/hard_scans.py -o OUT --scans 200 --seed 1 --calibration  another stream, to set thresholds on

Three of four scans can be done: walls or boards 5 to 30 cm behind, boxes, balls and cylinders with print, hands that
turn the object by uneven steps of up to 60 deg, parts of a turn and several, stops, both directions, axes that drift,
cables, people, plates of any shape, filtered depth, six cameras. One of four is planted to fail
(tools/hard/planting.py) and ought to be said failed, or doubtful. A mesh is good if its rms to the true object is
within 1.5 times that of the same depth integrated at the true poses, and as much of what was seen is there. A scan
that ends with status 0 and without a verdict says "good".

`OUT/table.txt` and `OUT/table.json` hold what is printed. The same seed makes the same scans.
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
from hard.drawing import drawn
from hard.judged import HEAD, Judged, judged, line, row, summary
from hard.making import make
from hard.planting import PLANTED

BULKY = ("recording", "masked", "posed", "result", "compare", "compare_posed")
STREAMS = {False: 2001, True: 2002}  # reported and calibration scans share no random number


def main() -> int:
    """Make, scan, judge, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--scans", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, nargs="+", metavar="K", help="these scans alone")
    parser.add_argument("--calibration", action="store_true", help="another stream of seeds than the reported one")
    parser.add_argument("--keep", action="store_true", help="keep recordings and results")
    parser.add_argument("--make-only", action="store_true", help="write the recordings and stop")
    parser.add_argument("--made", action="store_true", help="the recordings are there: judge them anew")
    options = parser.parse_args()
    scans: list[Judged] = []
    print(HEAD, flush=True)
    for k in range(options.scans) if options.only is None else options.only:
        folder = options.output / f"scan_{k:03d}"
        if not options.made:
            made(k, options.seed, options.calibration, folder)
        if options.make_only:
            continue
        scans.append(judged(folder))
        print(line(scans[-1]), flush=True)
        (folder / "judged.json").write_text(json.dumps(row(scans[-1]), indent=1), encoding="utf-8")
        for bulky in () if options.keep else BULKY:
            shutil.rmtree(folder / bulky, ignore_errors=True)
        told = summary(scans)
        (options.output / "table.txt").write_text("\n".join([HEAD, *map(line, scans), told, ""]), encoding="utf-8")
        (options.output / "table.json").write_text(json.dumps([row(s) for s in scans], indent=1), encoding="utf-8")
    if scans:
        print(summary(scans))
    return 0


def made(k: int, seed: int, calibration: bool, folder: Path) -> None:
    """Scan k; every fourth is planted, each failure in turn."""
    begin, rng = time.monotonic(), np.random.default_rng([STREAMS[calibration], seed, k])
    planted = PLANTED[k // 4 % len(PLANTED)] if k % 4 == 3 else ""
    scan = drawn(folder.name, planted, rng)
    make(scan, folder, rng)
    print(f"{folder.name}: made in {time.monotonic() - begin:.0f} s", file=sys.stderr, flush=True)


if __name__ == "__main__":
    raise SystemExit(main())
