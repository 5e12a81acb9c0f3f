"""Units of two sensors, each calibrated from its own boards and walls and then used to scan: how right is the scale?

    python -m tools.sets.fresh_units -o OUT --units 40 --seed 1             20 of each sensor, statues and blocks
    python -m tools.sets.fresh_units -o OUT --units 40 --seed 1 --only 7    one of them

A unit is drawn below the level of depth: phasors of a time-of-flight camera, dots of a structured-light one
(tools/sets/fresh, which shares no formula with the package). Its owner calibrates the camera from 20 boards and the
depth from 6 to 10 walls that a laser has measured, scans an object on a turntable, and compares with the true object;
the commands run in processes of their own. The same scan without errors, at its true poses, is what could be reached.
What walls and boards allow at best is in tools/sets/fresh/information.py, what the depth tells of angles in angles.py;
where a scale error comes from, `python -m tools.sets.fresh_stages`. The truth lies in OUT/unit_NN/truth.

`OUT/table.txt` and `OUT/table.json` hold what is printed. The same seed makes the same units.
"""

import os
from functools import partial
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # products of small matrices: threads would only wait

import numpy as np

from tools.sets.fresh.judged import judged
from tools.sets.fresh.making import make
from tools.sets.fresh.table import HEAD, line, row, summary
from tools.sets.fresh.unit import drawn
from tools.sets.judging.series import Series, Table, options_of

KINDS = ("itof", "structured_light")
SHAPES = ("statue", "blocks")
BULKY = ("board", "wall_*", "scan", "clean", "measured", "compare*", "posed*", "result")


def main() -> int:
    """Make, run, judge, print."""
    options = options_of(__doc__, "units", 40).parse_args()
    table = Table(HEAD, line, row, summary)
    return Series("unit_{:02d}", partial(made, options.seed), judged, table, BULKY).run(range(options.units), options)


def made(seed: int, k: int, folder: Path) -> None:
    """Unit k: sensors take turns, and so do objects."""
    rng = np.random.default_rng([seed, k])
    unit = drawn(KINDS[k % 2], SHAPES[k // 2 % 2], folder.name, rng)
    make(unit, folder, rng)


if __name__ == "__main__":
    raise SystemExit(main())
