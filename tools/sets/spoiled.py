"""What spoils a scan, and hard data: each planted once. What is said of it, and how far off is the mesh?

    python -m tools.sets.spoiled -o OUT --seed 1

Planted: the plate's light on time of flight, flying pixels, a table that wobbles, warm-up, an object that moved, thin
parts; then 8 views, a table turned by hand, a hand in the picture, 4 cm, half a turn, a symmetric and a shiny thing.
The generator and the judge share no code with the package.
"""

import os
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # products of small matrices: threads would only wait

import numpy as np

from tools.sets.judging.series import Series, Table, options_of
from tools.sets.spoiling.cases import CASES
from tools.sets.spoiling.judged import HEAD, judged, line, row, summary
from tools.sets.spoiling.making import make


def main() -> int:
    """Make, scan, judge, print."""
    options = options_of(__doc__, "cases", len(CASES)).parse_args()

    def made(k: int, folder: Path) -> None:
        make(CASES[k], folder, np.random.default_rng([2024, options.seed, k]))

    series = Series("case_{:02d}", made, judged, Table(HEAD, line, row, summary), ("pass_1",))
    return series.run(range(min(options.cases, len(CASES))), options)


if __name__ == "__main__":
    raise SystemExit(main())
