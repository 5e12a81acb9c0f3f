"""Two passes of one object, turned over between them: are they merged, and is what cannot be merged said?

    python -m tools.sets.passes -o OUT --seed 1              six objects before three cameras: what is reported
    python -m tools.sets.passes -o OUT --seed 1 --related    partial turns, other places of the camera, other cameras
    python -m tools.sets.passes -o OUT --seed 1 --refused    pairs that must not be merged
    python -m tools.sets.passes -o OUT --seed 101            to set thresholds on

Each pass has its own place of the camera; objects are turned over by a drawn rotation. `fusion turntable` scans both,
`fusion merge` merges the results; the same once more with the true transform (`--transforms`), for comparison. The
generator and the judge (tools/sets/two_passes) share no code with the package. The same seed makes the same recordings.
"""

import os
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # products of small matrices: threads would only wait

import numpy as np

from tools.sets.judging.series import Series, Table, options_of
from tools.sets.two_passes.cases import CASES, REFUSED, RELATED
from tools.sets.two_passes.judged import HEAD, judged, line, row, summary
from tools.sets.two_passes.making import make

BULKY = ("pass_?", "scan_?", "merged", "true")


def main() -> int:
    """Make, scan, merge, judge, print."""
    parser = options_of(__doc__, "pairs", len(CASES))
    kinds = parser.add_mutually_exclusive_group()
    kinds.add_argument("--refused", action="store_true", help="pairs that must not be merged")
    kinds.add_argument("--related", action="store_true", help="partial turns, other places, other cameras")
    parser.add_argument("--frames", type=int, default=36, help="of each pass")
    options = parser.parse_args()
    stream = 1 if options.refused else 2 if options.related else 0
    cases = (CASES, REFUSED, RELATED)[stream]

    def made(k: int, folder: Path) -> None:
        make(cases[k], folder, np.random.default_rng([2006, stream, options.seed, k]), options.frames)

    series = Series("pair_{:02d}", made, judged, Table(HEAD, line, row, summary), BULKY)
    return series.run(range(min(options.pairs, len(cases))), options)


if __name__ == "__main__":
    raise SystemExit(main())
