"""The turns of all views at once, from what pairs of them say: several turns may fit a pair, one set fits them all."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
CELLS = 180  # of the circle: 2 degrees each
BLUR = np.deg2rad(3.0)  # about what a pair of views may be off
SWEEPS = 40


@dataclass(frozen=True)
class Said:
    """What m pairs of views say, several lines for a pair.

    Attributes:
        pairs: (m, 2) views (i, j), i before j.
        turns: (m,) of j against i [rad].
        worth: (m,) how much it counts, 0 or more.
    """

    pairs: NDArray[np.intp]
    turns: Array
    worth: Array


def consistent(n: int, said: Said) -> Array:
    """Turns (n,) [rad] of the views on the circle, 0 at the first, with which most of what was said agrees.

    From the trees that the best pairs span, ever better: one view at a time, and all views after one together, as
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
    n = len(table)
    cells = np.arange(CELLS)
    for _ in range(SWEEPS):
        before = label.copy()
        for j in range(n):
            votes = np.zeros(CELLS)
            for i in range(n):
                if i != j:
                    votes += np.roll(table[i, j], label[i])
            if votes.max() > votes[label[j]] + 1e-9:
                label[j] = int(np.argmax(votes))
        for k in range(1, n):  # all views from k on together
            before_k, after_k = (a.ravel() for a in np.meshgrid(np.arange(k), np.arange(k, n), indexing="ij"))
            turn = (label[after_k] - label[before_k])[:, None] + cells
            votes = table[before_k[:, None], after_k[:, None], turn % CELLS].sum(axis=0)
            if votes.max() > votes[0] + 1e-9:
                label[k:] = (label[k:] + int(np.argmax(votes))) % CELLS
        if np.array_equal(before, label):
            break
    return label


def _value(table: Array, label: NDArray[np.intp]) -> float:
    i, j = np.triu_indices(len(label), 1)
    return float(table[i, j, (label[j] - label[i]) % CELLS].sum())
