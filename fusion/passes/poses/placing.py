"""How one pass lies to another: candidates of the whole pose search, refined, ranked by overlap and free space."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.mesh.alignment.coarse import CoarseSurface as Coarse
from fusion.mesh.alignment.coarse import by_features
from fusion.passes.poses.lying import Lying, judged, laid
from fusion.passes.poses.search import candidates
from fusion.passes.poses.sides import PassSide
from fusion.progress import stage

Array = NDArray[np.float64]
QUICK, FINE = 300, 1500  # points of each surface, for all candidates and for the best of them
TRIED, KEPT = 24, 12  # candidates that are judged, and refined finely
APART = 0.05  # of the object's size: transforms that place its surface so far apart (rms) are two (guess)


@dataclass(frozen=True)
class Placing:
    """The distinct ways in which a pass may lie to another, the best first."""

    found: tuple[Lying, ...]

    @property
    def best(self) -> Lying:
        return self.found[0]


def place(first: PassSide, second: PassSide) -> Placing:
    """Every way in which the second pass may lie to the first, no guess needed.

    Raises:
        nothing; a bad best says that they do not fit.
    """
    with stage("alignment"):
        starts = candidates(first, second) + _by_features(first, second)
        size = max(first.size, second.size)
        wide = np.geomspace(0.08, 0.02, 10) * size
        quick = [judged(first, second, laid(first, second, T, wide, QUICK)) for T in starts]
        tried = distinct(quick, second, TRIED)
        fine = np.geomspace(0.02 * size, max(first.noise, second.noise), 8)
        better = [judged(first, second, laid(first, second, one.T, fine, FINE)) for one in tried]
        return Placing(tuple(distinct(better, second, KEPT)))


def distinct(found: list[Lying], second: PassSide, most: int) -> list[Lying]:
    """The best of transforms, none that places the surface as a better one does."""
    kept: list[Lying] = []
    for one in sorted(found, key=lambda x: -x.score):
        if all(apart(one.T, other.T, second) > APART * second.size for other in kept):
            kept.append(one)
        if len(kept) == most:
            break
    return kept


def apart(one: Array, other: Array, side: PassSide) -> float:
    """Root mean square distance of a surface's places under two transforms [m]."""
    off = pose.transform(one, side.few.points) - pose.transform(other, side.few.points)
    return float(np.sqrt(np.mean(np.sum(off**2, axis=1))))


def _by_features(first: PassSide, second: PassSide) -> list[Array]:
    sides = (Coarse(side.few.points, side.few.normals, side.tree) for side in (second, first))
    return [guess.matrix() for guess in by_features(*sides)]
