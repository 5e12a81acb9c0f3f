"""Nearest: the entry of the catalogue that comes closest to an unknown law, and why it is not the one."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.discrepancy.unknown.law import UnknownLaw
from fusion.discrepancy.unknown.unrestricted import Group, explained

Vector = NDArray[np.float64]

MANY = 10  # numbers with which an entry is fitted: more than any formula has


@dataclass(frozen=True)
class Nearest:
    """An entry that was rejected."""

    name: str  # of the effect
    cosine: float  # between the law and the best that the entry can make of it
    gain: float  # share of the law's own gain that it reaches
    left: tuple[str, ...]  # variables on which what it leaves still depends
    numbers: int  # how many the entry is fitted with

    @property
    def reason(self) -> str:
        """Why it is not the one, as words."""
        share = f"it explains {100 * self.gain:.0f} % of what the unknown law explains"
        if self.numbers > MANY:  # which is why it may explain all of it, and still not be the one
            share += f", and needs {self.numbers} numbers for that"
        if not self.left:
            return share
        return f"{share}, and what it leaves still depends on {' and '.join(self.left)}"


def nearest_of(law: UnknownLaw, candidates: Sequence[Candidate], white: Vector, groups: list[Group]) -> Nearest | None:
    """The closest entry by its fit to the law; None when there is no entry at all."""
    length = max(float(np.linalg.norm(law.footprint)), 1e-300)
    best: tuple[float, Candidate] | None = None
    for candidate in candidates:
        alike = float(np.linalg.norm(candidate.basis.T @ law.footprint)) / length
        # a map of the image can follow anything a little
        alike -= candidate.basis.shape[1] / len(white)
        if best is None or alike > best[0]:
            best = (alike, candidate)
    if best is None:
        return None
    cosine, candidate = best
    own = candidate.basis.T @ white
    rest = white - candidate.basis @ own
    left = explained(rest, groups, candidate.basis)
    return Nearest(
        candidate.name,
        max(cosine, 0.0),
        min(float(own @ own) / max(law.gain, 1e-9), 1.0),
        left.variables if left.gain > 0 else (),
        candidate.basis.shape[1],
    )
