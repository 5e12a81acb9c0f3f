"""A centre that stands at one depth first and at another one then: camera or scene was bumped once."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FEWEST = 4  # frames on either side
CLEAR = 5.0  # of what is left beside the step: noise that wanders slowly makes smaller ones (guess)
SUDDEN = 0.5  # of it between one frame and the next
BESIDE_LINE = 2.0  # times more is left beside a straight line: a drift goes on

Array = NDArray[np.floating]


class Bump(NamedTuple):
    """From which frame on, and by how much [m]."""

    frame: int
    by: float


def bump_of(centre: Array) -> Bump | None:
    """The shift of a series (n,) [m] that may hold NaN; None where there is none, or where noise may be it."""
    known = np.flatnonzero(np.isfinite(centre))
    n = len(known)
    if n < 2 * FEWEST:
        return None
    x = np.asarray(centre[known] - np.mean(centre[known]), float)
    before = np.arange(1, n)
    sums = np.cumsum(x)[:-1]
    between = sums**2 * (1 / before + 1 / (n - before))  # of the sum of squares, what a step there takes out
    at = FEWEST - 1 + int(np.argmax(between[FEWEST - 1 : n - FEWEST]))
    left = float(x @ x - between[at])
    by = float(x[at + 1 :].mean() - x[: at + 1].mean())
    t = np.arange(n) - (n - 1) / 2
    beside_line = float(x @ x - (t @ x) ** 2 / (t @ t))
    clear = abs(by) > CLEAR * np.sqrt(max(left, 0.0) / (n - 2))
    sudden = abs(x[at + 1] - x[at]) > SUDDEN * abs(by)
    return Bump(int(known[at + 1]), by) if clear and sudden and beside_line > BESIDE_LINE * left else None
