"""How all passes lie to the first, and what speaks for it: symmetry, colour, overlap, free space."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.errors import TrackingError
from fusion.geometry import pose
from fusion.mesh.alignment.coarse import CoarseSurface as Coarse
from fusion.mesh.alignment.coarse import by_features
from fusion.passes.one_pass import Pass
from fusion.passes.poses.colors import decided, printed
from fusion.passes.poses.lying import Lying, judged, laid
from fusion.passes.poses.search import candidates
from fusion.passes.poses.sides import PassSide
from fusion.progress import stage

Array = NDArray[np.float64]
# the thresholds are guesses, looked at on development seeds of tools/sets/passes.py (101 and above)
LEAST_OVERLAP = 0.12  # of both surfaces together
LEAST_AGREEMENT = 0.93  # of what the other pass can say something of
LOOSE = 0.4  # rms over the noise: surfaces that cross at random have 0.5, those of one object 0.1 to 0.25
# another way to lie is as good where as little speaks against it, and where it rests on half as much surface or more:
# how much surface two passes share says nothing of what neither, or only one of them, has seen
EQUAL_THROUGH, EQUAL_RMS, EQUAL_OVERLAP = 0.008, 1.3, 0.5
TURN_MORE = "record passes that share at least a fifth of the surface, with a whole turn each"
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


@dataclass(frozen=True)
class Arranged:
    """How one pass lies to an earlier one."""

    onto: int  # index of the earlier pass
    lying: Lying  # the transform between both and what speaks for it
    second_score: float  # of the next best way in which it might lie; -1 where there is none
    symmetric: bool  # the next best is as good: shape cannot tell them apart
    # correlation of the colours, and of the next best way, where they decided; else None
    colors: tuple[float, float] | None = None


def arranged(passes: Sequence[Pass], sides: Sequence[PassSide], k: int, color: bool) -> Arranged:
    """Lay pass k on the first of the earlier ones that it fits.

    Raises:
        TrackingError: it fits none: too little overlap, another object, or symmetric without colours that decide.
    """
    tried = []
    for onto in range(k):
        placing = place(sides[onto], sides[k])
        tried.append((onto, placing))
        if fits(placing.best, sides[onto]):
            return _told(passes, sides, (k, onto), placing, color)
    onto, placing = max(tried, key=lambda one: one[1].best.score)
    raise _refusal(passes[onto], passes[k], placing.best)


def fits(one: Lying, side: PassSide) -> bool:
    """Whether two passes lie on each other as those of one object do."""
    return one.overlap >= LEAST_OVERLAP and one.agreement >= LEAST_AGREEMENT and one.rms < LOOSE * side.noise


def as_good(one: Lying, best: Lying) -> bool:
    """Whether nothing that was seen tells a transform from the best."""
    return (
        one.through <= best.through + EQUAL_THROUGH
        and one.rms <= EQUAL_RMS * best.rms
        and one.overlap >= EQUAL_OVERLAP * best.overlap
    )


def _told(
    passes: Sequence[Pass], sides: Sequence[PassSide], pair: tuple[int, int], placing: Placing, color: bool
) -> Arranged:
    k, onto = pair
    best, second = placing.best, placing.found[1:2]
    second_score = second[0].score if second else -1.0
    rivals = [best, *(one for one in placing.found[1:] if fits(one, sides[onto]) and as_good(one, best))]
    if len(rivals) == 1:
        return Arranged(onto, best, second_score, False)
    meshes = passes[onto].mesh, passes[k].mesh
    shown = printed(meshes, (sides[onto], sides[k])) if color else None
    found = None if shown is None else decided(shown, sides[onto], sides[k], rivals)
    if found is None:
        why = "no colour in both passes" if shown is None else "colours that do not decide"
        ways = f"{len(rivals)} ways to lie equally well ({best.overlap:.0%} of the surface), {why}"
        do = "put marks on it and record colour, or pass --transforms"
        raise TrackingError("symmetric: the passes cannot be told apart", passes[k].name, ways, do=do)
    return Arranged(onto, found[0], second_score, True, found[1:])


def _refusal(first: Pass, second: Pass, best: Lying) -> TrackingError:
    found = (
        f"at best {best.overlap:.0%} of the surface on each other, {best.through:.0%} where the other looked through"
    )
    where = f"{first.name} and {second.name}"
    if best.through > best.overlap / 8 or best.overlap > 2 * LEAST_OVERLAP:
        what, do = "the passes do not show one object", "check that both are good scans of the same rigid thing"
    else:
        what, do = "the passes share too little surface", TURN_MORE
    return TrackingError(what, where, found, "one surface that no pass looks through", do)
