"""Pairs of views compared at turns all round the circle: what each pair says, by shape and by print."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fusion.turntable.all_views.together import REACH
from fusion.turntable.axis import Axis
from fusion.turntable.guess.labels import Said
from fusion.turntable.pairs.edges import Edges, ViewStack
from fusion.turntable.pairs.pairwise import HELD, Registered, Twists, ViewPairLimits, coarser, register, registered

Array = NDArray[np.float64]
SPACING = np.deg2rad(5.0)
KEPT = 4  # turns of a pair that are looked at closer
APART = 4  # cells between them
GRID_POINTS = 250
ASIDE = (0.0, -0.012, 0.012)  # [m] where to start: print guides over some pixels only, whatever the size (guess)
FIRST_POINTS = 300
ROUGH = (ViewPairLimits(REACH, most=GRID_POINTS),)
LOOSE = 0.02  # [m] how far a hand may move the axis from view to view (guess)
WRONG = 0.5  # misfit that says nothing any more (guess)
PRINT = 3.0  # how much more print counts than shape, which repeats: sides of a box, all of a round thing (guess)
PLAIN = (0.25, 0.6, 0.3)  # neighbours' prints agree by less where there is none, by more where it is rich; least shape
ROW = 2  # views that follow each other
STEP = np.deg2rad(90)  # between them: smaller ones are likelier (guess)
ALIKE = 0.5  # second best over best turn from which a match of distant views tells nothing (guess)
TONE = 0.12  # spread of the contrasts' differences at the right place, about (guess)
GUIDED = (ViewPairLimits(REACH, most=FIRST_POINTS), ViewPairLimits(REACH / 2, 0.0, 2 * TONE, FIRST_POINTS))


@dataclass(frozen=True)
class Heard:
    """Candidates of all pairs."""

    edges: Edges  # m lines: source and model view
    found: Registered  # their motions
    shape: Array  # (m,) share of what both views see that fits

    @cached_property
    def _rank(self) -> dict[int, int]:
        return {view: k for k, view in enumerate(sorted({view for edge in self.edges for view in edge}))}

    def apart(self, pair: tuple[int, int]) -> int:
        """How many views lie from one to the other, of those that were compared."""
        return self._rank[pair[1]] - self._rank[pair[0]]

    def printed(self) -> float:
        """How much print tells, 0 to 1: where there is some, neighbours agree in it."""
        best: dict[tuple[int, int], float] = {}
        for edge, alike, shape in zip(self.edges, self.found.at.alike, self.shape, strict=True):
            if shape > PLAIN[2]:
                best[edge] = max(best.get(edge, -1.0), float(alike))
        near = [alike for pair, alike in best.items() if self.apart(pair) == 1] or list(best.values())
        return float(np.clip((np.median(near) - PLAIN[0]) / (PLAIN[1] - PLAIN[0]), 0, 1)) if near else 0.0

    def worth(self, printed: float) -> Array:
        """(m,) how much each candidate counts: fitting shape, and where there is print, print that agrees."""
        return np.asarray(self.shape * (1 - printed + printed * PRINT * np.clip(self.found.at.alike, 0, 1)))

    def said(self, printed: float) -> Said:
        """For `labels.consistent`.

        Views that follow each other are near, the nearer the likelier. All others count as much as a match tells: of a
        thing that looks alike from several sides, one that fits is hardly more likely to be the right one.
        """
        worth, pairs = self.worth(printed), np.array(self.edges, np.intp).reshape(-1, 2)
        near = np.array([self.apart(pair) <= ROW for pair in self.edges], bool)
        told = float(np.clip(1 - self.ambiguity(worth) / ALIKE, 0, 1)) ** 2
        told *= min(1.0, near.sum() / max((~near).sum(), 1))  # there are many of them, and they err together
        worth = worth * np.where(near, np.exp(-np.abs(self.found.turns) / STEP), told)
        return Said(pairs, self.found.turns, worth)

    def ambiguity(self, worth: Array) -> float:
        """How good the second best turn of neighbours is, over the best one, 0 to 1 (mean)."""
        best: dict[tuple[int, int], list[tuple[float, float]]] = {}
        for edge, turn, value in zip(self.edges, self.found.turns, worth, strict=True):
            best.setdefault(edge, []).append((float(value), float(turn)))
        ratios = []
        for (i, j), lines in best.items():
            first, at = max(lines)
            if self.apart((i, j)) <= ROW and first > 0:
                off = [(value, (turn - at + np.pi) % (2 * np.pi) - np.pi) for value, turn in lines]
                ratios.append(max((v for v, o in off if abs(o) > np.deg2rad(25)), default=0.0) / first)
        return float(np.mean(ratios)) if ratios else 0.0


def listen(seen: ViewStack, axis: Axis, edges: Edges, largest: float = np.pi) -> Heard:
    """What each pair of views says of its turn, several candidates each.

    Args:
        seen: the views.
        axis: about which, roughly.
        edges: m pairs.
        largest: of the turns that are tried [rad].
    """
    n = int(np.ceil(largest / SPACING))
    grid = np.arange(-n, n + (largest < np.pi)) * SPACING
    tried = [edge for edge in edges for _ in grid]
    turned = axis.turns(np.tile(grid, len(edges)))
    # a hand, or an axis beside the true one, leaves them apart: print would meet print only by chance
    rough = registered(seen, tried, axis, register(seen, tried, axis, turned, ROUGH, LOOSE, 2, HELD), ROUGH[-1])
    good = _fitting(rough.at, np.minimum(_points(seen, tried), GRID_POINTS))
    good = (good * (1 + np.clip(rough.at.alike, 0, 1))).reshape(len(edges), len(grid))
    chosen, which = _peaks(good, largest >= np.pi)
    some = [edges[k] for k in chosen]
    best = _guided(seen, some, axis, rough.poses[chosen * len(grid) + which])
    passes = (ViewPairLimits(REACH / 2, 0.0, TONE), ViewPairLimits(REACH / 3, 1.5, TONE))
    found = registered(seen, some, axis, register(seen, some, axis, best, passes, LOOSE), passes[-1])
    return Heard(some, found, _fitting(found.at, np.minimum(_points(seen, some), passes[-1].most)))


def _guided(seen: ViewStack, edges: Edges, axis: Axis, met: Array) -> Array:
    """Motions (m, 4, 4) of m pairs: as shape brought them together, `met`, or as blurred print guides from there and
    from beside it, whichever fits best; of small things the blur leaves no print, of large ones it reaches farther."""
    sideways = np.cross(axis.direction, axis.point)  # along the surface that is seen: there shape slides
    beside = np.repeat(met[None], len(ASIDE), axis=0)
    beside[..., :3, 3] += np.multiply.outer(ASIDE, sideways / np.linalg.norm(sideways))[:, None]
    guided = register(coarser(seen), edges * len(ASIDE), axis, beside.reshape(-1, 4, 4), GUIDED, LOOSE)
    ways, many = np.concatenate([met, guided]), edges * (1 + len(ASIDE))
    at = registered(seen, many, axis, ways, GUIDED[-1]).at
    good = _fitting(at, np.minimum(_points(seen, many), FIRST_POINTS)) * (1 + PRINT * np.clip(at.alike, 0, 1))
    best = good.reshape(1 + len(ASIDE), -1).argmax(axis=0)
    return np.asarray(ways.reshape(1 + len(ASIDE), -1, 4, 4)[best, np.arange(len(edges))])


def _points(seen: ViewStack, edges: Edges) -> Array:
    return np.asarray(np.diff(seen.first)[[i for i, _ in edges]], float)


def _fitting(at: Twists, points: Array) -> Array:
    """(m,) what speaks for motions: the share of what both see that fits."""
    share = np.minimum(at.visible / np.maximum(points, 1), 1.0)
    return np.asarray(share * np.clip(1 - at.misfit / WRONG, 0, 1))


def _peaks(good: Array, round_: bool) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pair and cell of the best local maxima of (m, k), APART cells from each other."""
    left, rows, cells = good.copy(), [], []
    k = good.shape[1]
    everyone = np.arange(len(good))
    for _ in range(KEPT):
        best = left.argmax(axis=1)
        some = left[everyone, best] > 0.02
        rows.append(everyone[some])
        cells.append(best[some])
        for off in range(-APART, APART + 1):
            at = (best + off) % k if round_ else np.clip(best + off, 0, k - 1)
            left[everyone, at] = -1
    return np.concatenate(rows), np.concatenate(cells)
