"""Whether what is printed on the object agrees between frames that the motion lays on each other.

Planes and round things slip in shape alone, and a box looks alike from both sides; print does not. Which frames are
compared is chosen by the motion alone: those that it says look at the same surface.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fusion.recording.ahead import ahead
from fusion.scan.judging.print_pairs import PrintedFrame, compared, printed
from fusion.turntable.all_views.loop import choose_edges
from fusion.turntable.all_views.together import WIDEST
from fusion.turntable.views import Region
from fusion.volume.prepared import Prepared

Array = NDArray[np.float64]
CHANCES = 3.0  # standard deviations: one pair of a thousand by chance
MOST = 0.999  # correlation: more alike than that are a few places, whose inverse tangent has no end
LEAST = 0.2  # correlation of a print with itself a little beside, from which there is print: noise leaves 0.1


@dataclass(frozen=True)
class PrintAgreement:
    """What m pairs of n frames say."""

    edges: NDArray[np.intp]  # (m, 2) of the n
    # alike, own, chance: (m,) see `PrintPair`; NaN where a pair shares too little
    alike: Array
    own: Array
    chance: Array
    count: int  # n

    @property
    def agree(self) -> NDArray[np.bool_]:
        """(m,) pairs that show the same print beyond chance."""
        return np.asarray(_fisher(self.alike) > CHANCES * self._doubt)

    @property
    def differ(self) -> NDArray[np.bool_]:
        """(m,) pairs that do not, and less than print that lies a little off would, beyond chance."""
        less = _fisher(self.own) - np.maximum(_fisher(self.alike), 0.0)
        return np.asarray(self._print & (less > CHANCES * self._doubt) & ~self.agree)

    @property
    def against(self) -> float:
        """Share of the pairs that differ, of those that say anything; NaN where none does."""
        telling = int((self.agree | self.differ).sum())
        return float(self.differ.sum() / telling) if telling else float("nan")

    @property
    def loose(self) -> float:
        """Share of the frames with print that no chain of agreeing pairs holds together with most; NaN: no print."""
        shown = np.unique(self.edges[self._print])
        if not len(shown):
            return float("nan")
        i, j = self.edges[self.agree & self._print].T
        graph = coo_array((np.ones(len(i)), (i, j)), (self.count, self.count))
        group = connected_components(graph, directed=False)[1][shown]
        return float(1 - np.bincount(group).max() / len(shown))

    @property
    def _print(self) -> NDArray[np.bool_]:
        return np.asarray((self.own > LEAST) & np.isfinite(self.alike))

    @property
    def _doubt(self) -> Array:
        """(m,) standard deviation of the inverse hyperbolic tangent of a correlation by chance (Fisher 1921).

        That of n values is 1 / sqrt(n - 3), where the correlation's own is 1 / sqrt(n - 1); above it all is possible.
        A pair asks few places, so at least what is usual.
        """
        known = self.chance[np.isfinite(self.chance)]
        chance = np.maximum(self.chance, np.median(known)) if len(known) else self.chance
        left = 1 - 2 * chance**2
        return np.asarray(np.where(left > 0, chance / np.sqrt(np.maximum(left, 1e-12)), np.inf))


def _fisher(correlation: Array) -> Array:
    """The same with a standard deviation that does not hang on it (Fisher 1921)."""
    return np.asarray(np.arctanh(np.clip(correlation, -MOST, MOST)))


def print_agreement(
    frames: list[Prepared | None], region: Region, T_object_camera: Array, angles: Array
) -> PrintAgreement | None:
    """Compare frames that look at the same surface; None where nothing shows colours.

    Args:
        frames: (n) cut to the window of the region.
        region: where the object is; its images cut to the same window.
        T_object_camera: (n, 4, 4), NaN where a frame has no place.
        angles: (n,) turn of each frame [rad], NaN likewise.
    """

    def view(k: int) -> PrintedFrame | None:
        frame, T = frames[k], T_object_camera[k]
        return printed(frame, region, T) if frame is not None and np.isfinite(T).all() else None

    views = {k: v for k, seen in enumerate(ahead(view, range(len(frames)))) if (v := seen()) is not None}
    placed = list(views)
    edges = choose_edges(angles[placed], WIDEST)
    if not edges:
        return None
    pairs = [(views[placed[i]], views[placed[j]]) for i, j in edges]
    found = [said() for said in ahead(lambda pair: compared(*pair), pairs)]
    alike, own, chance = np.array([(f.alike, f.own, f.chance) for f in found]).T
    return PrintAgreement(np.array(edges, np.intp), alike, own, chance, len(placed))
