"""The turns of all views at once, from what pairs of them say: several turns may fit a pair, one set fits them all."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
CELLS = 180  # of the circle: 2 degrees each
BLUR = np.deg2rad(3.0)  # about what a pair of views may be off
MOVES = 200


@dataclass(frozen=True)
class Said:
    """What m pairs of views say, several lines for a pair."""

    pairs: NDArray[np.intp]  # (m, 2) views (i, j), i before j
    turns: Array  # (m,) of j against i [rad]
    worth: Array  # (m,) how much it counts, 0 or more

    def beside(self, other: "Said") -> "Said":
        """What both say."""
        pairs = np.concatenate([self.pairs, other.pairs])
        return Said(pairs, np.append(self.turns, other.turns), np.append(self.worth, other.worth))


def consistent(n: int, said: Said) -> Array:
    """Turns (n,) [rad] of the views on the circle, 0 at the first, with which most of what was said agrees.

    From the trees that the best pairs span, ever better: one view at a time, and stretches of views together, as
    long as that agrees with more.
    """
    table = _table(n, said)
    best, value = np.zeros(n, int), -1.0
    for root in range(min(n, 8)):
        found = _tree(table, root * n // min(n, 8))
        found = _improved(table, found)
        agreed = _value(table, found)
        if agreed > value + 1e-9:
            best, value = found, agreed
    return np.asarray(((best - best[0]) % CELLS) * 2 * np.pi / CELLS)


def unwound(turns: Array) -> Array:
    """Turns (n,) on the circle as a hand makes them one after the other: the shorter way each time [rad]."""
    steps = (np.diff(turns) + np.pi) % (2 * np.pi) - np.pi
    return np.concatenate([[0.0], np.cumsum(steps)])


def _table(n: int, said: Said) -> Array:
    """(n, n, CELLS) how much speaks for each turn of the second view against the first."""
    table = np.zeros((n, n, CELLS))
    centres = np.arange(CELLS) * 2 * np.pi / CELLS
    for (i, j), turn, worth in zip(said.pairs, said.turns, said.worth, strict=True):
        off = (centres - turn + np.pi) % (2 * np.pi) - np.pi
        # what is said twice counts once
        table[i, j] = np.maximum(table[i, j], worth * np.exp(-0.5 * (off / BLUR) ** 2))
    backward = np.roll(table[..., ::-1], 1, axis=2)
    return table + backward.swapaxes(0, 1)


def _tree(table: Array, root: int) -> NDArray[np.intp]:
    """Labels (n,) along the tree of the pairs that speak clearest."""
    n = len(table)
    peak, where = table.max(axis=2), table.argmax(axis=2)
    label, placed = np.zeros(n, int), np.zeros(n, bool)
    placed[root] = True
    for _ in range(n - 1):
        open_pairs = np.where(placed[:, None] & ~placed[None], peak, -1.0)
        # near neighbours where nothing speaks
        open_pairs = open_pairs - 1e-9 * np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
        i, j = np.unravel_index(int(np.argmax(open_pairs)), open_pairs.shape)
        label[j], placed[j] = label[i] + where[i, j], True
    return label % CELLS


def _improved(table: Array, label: NDArray[np.intp]) -> NDArray[np.intp]:
    """Labels (n,) after the best shifts of a view, or of views that follow each other, one after the other."""
    n, label = len(table), label.copy()
    first, last = np.array([*combinations(range(n + 1), 2)]).T  # of all stretches of views
    for _ in range(MOVES):
        turn = np.subtract.outer(label, label).T[..., None] + np.arange(CELLS)
        sums = np.zeros((n + 1, n + 1, CELLS))
        sums[1:, 1:] = np.take_along_axis(table, turn % CELLS, axis=2).cumsum(axis=0).cumsum(axis=1)
        inside = sums[last, last] - sums[first, last] - sums[last, first] + sums[first, first]
        votes = sums[n, last] - sums[n, first] - inside  # what all others say of a stretch
        gain = votes - votes[:, :1]
        best, shift = np.unravel_index(int(np.argmax(gain)), gain.shape)
        if gain[best, shift] < 1e-9:
            break
        label[first[best] : last[best]] = (label[first[best] : last[best]] + shift) % CELLS
    return label


def _value(table: Array, label: NDArray[np.intp]) -> float:
    i, j = np.triu_indices(len(label), 1)
    return float(table[i, j, (label[j] - label[i]) % CELLS].sum())
