"""Pairs of views that agree with the turns of all, and the turns of views between those that were compared."""

import numpy as np
from numpy.typing import NDArray

from fusion.turntable.axis import Axis
from fusion.turntable.guess.everywhere import Heard, listen
from fusion.turntable.pairs.edges import Edges, ViewStack

Array = NDArray[np.float64]

NEIGHBOURS = np.deg2rad(75)  # largest turn between these that is tried (guess)
AGREES = np.deg2rad(8)  # of a pair and the labels (guess)
LEAST = 0.25  # worth of a pair that takes part (guess)


def agreeing(heard: Heard, printed: float, turns: Array) -> tuple[Edges, Array, Array]:
    """The best candidate of each pair that agrees with turns (n,): edges, motions (m, 4, 4), worth (m,)."""
    worth = heard.worth(printed)
    best: dict[tuple[int, int], int] = {}
    for k, (i, j) in enumerate(heard.edges):
        off = (heard.found.turns[k] - turns[j] + turns[i] + np.pi) % (2 * np.pi) - np.pi
        if abs(off) < AGREES and worth[k] > LEAST and ((i, j) not in best or worth[k] > worth[best[i, j]]):
            best[i, j] = k
    chosen = list(best.values())
    return list(best), heard.found.poses[chosen], worth[chosen]


def places_between(
    seen: ViewStack, axis: Axis, keys: NDArray[np.intp], turns: Array, printed: float
) -> tuple[Edges, Array, Array]:
    """Places `turns` of the views between keys, by the keys before and after; what they say, as `agreeing`."""
    others = np.flatnonzero(np.isnan(turns))
    after = np.searchsorted(keys, others)
    pairs = [(int(keys[a - k]), int(o)) for a, o in zip(after, others, strict=True) for k in (1, 0)]
    heard = listen(seen, axis, pairs, NEIGHBOURS)
    said = heard.said(printed)
    for o, a in zip(others, after, strict=True):
        first, second = keys[a - 1], keys[a]
        rest = (turns[second] - turns[first] + np.pi) % (2 * np.pi) - np.pi
        share = (o - first) / (second - first)
        turns[o] = turns[first] + share * rest
        mine = np.flatnonzero(said.pairs[:, 1] == o)
        at = turns[said.pairs[mine, 0]] + said.turns[mine]
        if len(mine):
            apart = (at[:, None] - at + np.pi) % (2 * np.pi) - np.pi
            # what both say; of equals the one nearer to an even hand
            off = (at - turns[o] + np.pi) % (2 * np.pi) - np.pi
            votes = np.exp(-0.5 * (apart / np.deg2rad(3)) ** 2) @ said.worth[mine] * (1 - 0.1 * np.abs(off))
            turns[o] = at[int(np.argmax(votes))]
    return agreeing(heard, printed, turns)
