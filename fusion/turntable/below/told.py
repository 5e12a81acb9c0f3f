"""What marks below the object say of the turns of all views."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.turntable.all_views.joint import PairMotions
from fusion.turntable.axis import Axis
from fusion.turntable.below.marks import Marked, Marks
from fusion.turntable.below.meeting import Meeting, meetings
from fusion.turntable.guess.labels import BLUR, Said
from fusion.turntable.pairs.edges import Edges

Array = NDArray[np.float64]
FEW = 12  # views of which all pairs are compared; of more, those that follow each other and a few around
AHEAD = 3
AROUND = 8
HALF = 0.5  # of the views: where fewer surely meet another, the ground tells nothing
COUNTS = 3.0  # how much a sure meeting counts beside what shape and print of the object say, which is up to 4 (guess)
# [rad], [m] what a meeting may be off: pixels of a view from above, on a ground that is not quite level (guess)
ANGLE, SHIFT = np.deg2rad(0.4), 0.001


@dataclass(frozen=True)
class ToldBelow:
    """How the ground turned between pairs of views, several lines for a pair."""

    upright: Axis  # through the middle of the square that was looked at
    met: Sequence[tuple[tuple[int, int], Meeting]]

    def said(self) -> Said:
        """For `labels.consistent`."""
        pairs = np.array([pair for pair, _ in self.met], np.intp).reshape(-1, 2)
        turns, sure = np.array([(m.turn, m.sure) for _, m in self.met]).reshape(-1, 2).T
        return Said(pairs, turns, COUNTS * sure)

    def agreeing(self, turns: Array, keys: NDArray[np.intp]) -> PairMotions:
        """The surest of each pair that agrees with turns (n,), by the numbers of the views (n,) among all."""
        best: dict[tuple[int, int], Meeting] = {}
        for (i, j), m in sorted(self.met, key=lambda line: line[1].sure):
            off = (m.turn - turns[j] + turns[i] + np.pi) % (2 * np.pi) - np.pi
            if abs(off) < 2 * BLUR:
                best[int(keys[i]), int(keys[j])] = m
        poses = self.upright.turns(np.array([m.turn for m in best.values()]))
        poses[:, :3, 3] += np.array([m.shift for m in best.values()]).reshape(-1, 2) @ self.upright.across()
        sure = np.array([m.sure for m in best.values()])
        return PairMotions(list(best), poses, sure, angle=ANGLE, shift=SHIFT)


def told_below(below: Marked | None, marks: Sequence[Marks | None]) -> ToldBelow | None:
    """What marks of views (n) say; None where there are too few of them, or they stand still."""
    if below is None:
        return None
    n, seen = len(marks), {i: m for i, m in enumerate(marks) if m is not None}

    def lines(pairs: Edges) -> list[tuple[tuple[int, int], Meeting]]:
        both = [(i, j) for i, j in pairs if i in seen and j in seen]
        return [((i, j), m) for i, j in both for m in meetings(seen[i], seen[j], below.ground) if m.sure > 0]

    near = [(k, k + 1) for k in range(n - 1)]
    met = lines(near)
    if not any(m.sure >= 1 for _, m in met):
        return None
    met += lines([pair for pair in _pairs(n) if pair not in near])
    sure = {view for pair, m in met if m.sure >= 1 for view in pair}
    return ToldBelow(below.ground.upright, met) if len(sure) >= HALF * n else None


def _pairs(n: int) -> Edges:
    some = range(n) if n <= FEW else np.unique(np.linspace(0, n - 1, AROUND).round().astype(int)).tolist()
    around = {(i, j) for i in some for j in some if i < j}
    return sorted(around | {(i, j) for i in range(n) for j in range(i + 1, min(i + AHEAD, n - 1) + 1)})
