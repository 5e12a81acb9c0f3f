"""The hard set: is what comes of a turntable scan good, and does the scan know it?

    python -m tools.sets.hard_scans -o OUT --scans 60 --seed 1                   the set that is reported
    python -m tools.sets.hard_scans -o OUT --scans 200 --seed 1 --calibration    another stream, to set thresholds on

Three of four scans can be done: walls or boards 5 to 30 cm behind, boxes, balls and cylinders with print, hands that
turn the object by uneven steps of up to 60 deg, parts of a turn and several, stops, both directions, axes that drift,
cables, people, plates of any shape, filtered depth, six cameras. One of four is planted to fail
(tools/sets/hard/planting.py) and ought to be said failed, or doubtful. A mesh is good if its rms to the true object is
within 1.5 times that of the same depth integrated at the true poses, and as much of what was seen is there. A scan
that ends with status 0 and without a verdict says "good".

`OUT/table.txt` and `OUT/table.json` hold what is printed. The same seed makes the same scans.
"""

import os
from functools import partial
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # products of small matrices: threads would only wait

import numpy as np

from tools.sets.hard.drawing import drawn
from tools.sets.hard.judged import HEAD, judged, line, row, summary
from tools.sets.hard.making import make
from tools.sets.hard.planting import PLANTED
from tools.sets.judging.series import Series, Table, options_of

BULKY = ("recording", "masked", "posed", "result", "compare", "compare_posed")
STREAMS = {False: 2001, True: 2002}  # reported and calibration scans share no random number


def main() -> int:
    """Make, scan, judge, print."""
    parser = options_of(__doc__, "scans", 60)
    parser.add_argument("--calibration", action="store_true", help="another stream of seeds than the reported one")
    options = parser.parse_args()
    make_one = partial(made, (STREAMS[options.calibration], options.seed))
    series = Series("scan_{:03d}", make_one, judged, Table(HEAD, line, row, summary), BULKY)
    return series.run(range(options.scans), options)


def made(stream: tuple[int, int], k: int, folder: Path) -> None:
    """Scan k; every fourth is planted, each failure in turn."""
    rng = np.random.default_rng([*stream, k])
    planted = PLANTED[k // 4 % len(PLANTED)] if k % 4 == 3 else ""
    scan = drawn(folder.name, planted, rng)
    make(scan, folder, rng)


if __name__ == "__main__":
    raise SystemExit(main())
