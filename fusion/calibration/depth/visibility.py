"""Which numbers the walls can show at all, and what to record for those they cannot."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fusion.calibration.depth.laws.candidates import DELAYS, TILTS
from fusion.calibration.depth.laws.information import Information
from fusion.calibration.depth.laws.terms import BOARD, LawTerm

LEAST = 0.02  # share of a term that must survive tilts and distances: below, rounding and lens errors decide
# the same of a term that is 0 at the middle, where distances do not help: what else the walls hold that no law does
# comes into it divided by its share, and walls left out cannot tell, as their tilts are free too (guess)
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


def visibilities(terms: list[LawTerm], parts: Sequence[Information], measured: int) -> list[TermVisibility]:
    """For every term, by what each wall says; `measured`: how many of the walls have a known distance."""
    found, walls = [], len(parts)
    told = np.maximum([np.diag(part.M) for part in parts], 0.0)
    # what no law holds comes into a number by each wall as far as that tells it: walls whose tilts take a term whole
    # do not hide what boards, whose tilts are known, say of it
    spoiled = np.sqrt(told * [part.raw for part in parts]).sum(axis=0)
    for term, own, reach in zip(terms, told.sum(axis=0).tolist(), spoiled.tolist(), strict=True):
        share = own / reach if reach > 0 else 0.0
        smallest = SURE / np.sqrt(own) if own > 0 and share > 1e-6 else float("inf")
        # where distances are known, noise alone decides; where not, what survives the free poses
        left = share >= LEAST_SHAPE if term.shape else share >= LEAST or measured >= 2
        seen = smallest < 20 * term.typical and left
        if term.effect == BOARD and not seen:
            continue  # a board that mirrors nothing: nobody misses that
        found.append(TermVisibility(term, share, float(smallest), seen, "" if seen else _advice(term, measured, walls)))
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
