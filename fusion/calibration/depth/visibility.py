"""Which numbers the walls can show at all, and what to record for those they cannot."""

from dataclasses import dataclass

import numpy as np

from fusion.calibration.depth.laws.candidates import DELAYS, TILTS
from fusion.calibration.depth.laws.selection import Problem
from fusion.calibration.depth.laws.terms import BOARD, LawTerm
from fusion.calibration.depth.laws.variance import FLAT

LEAST = 0.02  # share of a term that must survive tilts and distances: below, rounding and lens errors decide
# the same of a term that is 0 at the middle, where distances do not help: what else the walls hold that no law does
# comes into it divided by its share, and walls left out cannot tell, as their tilts are free too (guess); where its
# number is known to less than its usual size though walls are not quite flat, less may survive
LEAST_SHAPE = 0.2
SURE = 5.0  # standard deviations from which an effect counts as found


@dataclass(frozen=True)
class TermVisibility:
    """What becomes of one term when every wall's tilt and distance are free as far as they are."""

    term: LawTerm  # which
    share: float  # of its norm that is left on the walls that tell it, 0 to 1
    smallest: float  # number that would be found at five standard deviations if it were alone, in the term's unit
    seen: bool  # False when nothing can be said
    record: str  # what to record to see it; empty when it is seen


def visibilities(terms: list[LawTerm], problem: Problem, measured: int) -> list[TermVisibility]:
    """For every term, by what each wall says; `measured`: how many of the walls have a known distance.

    A term that is 0 at the middle is judged by the standard deviation that its number reaches beside walls that all
    are off a plane in the way that spoils it most; that is held against its usual size.
    """
    found, walls = [], len(problem.information)
    told = np.maximum([np.diag(part.M) for part in problem.information], 0.0)
    # what no law holds comes into a number by each wall as far as that tells it: walls whose tilts take a term whole
    # do not hide what boards, whose tilts are known, say of it
    spoiled = np.sqrt(told * [part.raw for part in problem.information]).sum(axis=0)
    uneven = FLAT * np.sqrt([np.sum(1 / e.variance) for e in problem.evidence]) @ np.sqrt(told)
    sums = np.array([told.sum(axis=0), spoiled, uneven]).T.tolist()
    for term, (own, reach, off) in zip(terms, sums, strict=True):
        share = own / reach if reach > 0 else 0.0
        known = own > 0 and share > 1e-6
        smallest = SURE / float(np.sqrt(own)) if known else float("inf")
        std = float(np.hypot(smallest / SURE, off / own)) if known else float("inf")
        # where distances are known, noise alone decides; where not, what survives the free poses
        of_shape = share >= LEAST_SHAPE or std < term.typical
        left = of_shape if term.shape else share >= LEAST or measured >= 2
        seen = smallest < 20 * term.typical and left
        if term.effect == BOARD and not seen:
            continue  # a board that mirrors nothing: nobody misses that
        record = "" if seen else _advice(term, measured, walls)
        found.append(TermVisibility(term, share, smallest, seen, record))
    return found


def _advice(term: LawTerm, measured: int, walls: int) -> str:
    if term.effect == "amplitude_error":
        return "walls with dark and bright patches, with IR images"
    if term.key in DELAYS + TILTS:
        return "a board whose corners tell the wall's tilt: a free tilt takes what is linear in the image"
    if walls < 3:
        return "walls at three or more distances, with distance_m in telemetry.csv"
    if measured < walls:
        return "the distance of each wall (distance_m in telemetry.csv)"
    return "walls at more distances, tilted ones among them"
