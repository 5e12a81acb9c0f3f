"""Nearest: the entry of the catalogue that comes closest to an unknown law, and why it is not the one."""

from collections.abc import Sequence
from typing import Annotated

import numpy as np
from msgspec import Meta, Struct
from numpy.typing import NDArray

from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.discrepancy.unknown.law import UnknownLaw
from fusion.discrepancy.unknown.unrestricted import Group, explained

Vector = NDArray[np.float64]

MANY = 10  # numbers with which an entry is fitted: more than any formula has


class NearestEffect(Struct, frozen=True, kw_only=True):
    """The entry of the catalogue that comes nearest to an unknown law, and why it is not that."""

    effect: str
    cosine: Annotated[float, Meta(description="between the law and the best that the entry can make of it")]
    reason: str


def nearest_of(
    law: UnknownLaw, candidates: Sequence[Candidate], white: Vector, groups: list[Group]
) -> NearestEffect | None:
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
    gain = min(float(own @ own) / max(law.gain, 1e-9), 1.0)
    depends = left.variables if left.gain > 0 else ()
    return NearestEffect(
        effect=candidate.name, cosine=max(cosine, 0.0), reason=_reason(gain, candidate.basis.shape[1], depends)
    )


def _reason(gain: float, numbers: int, left: tuple[str, ...]) -> str:
    share = f"it explains {100 * gain:.0f} % of what the unknown law explains"
    if numbers > MANY:  # which is why it may explain all of it, and still not be the one
        share += f", and needs {numbers} numbers for that"
    return f"{share}, and what it leaves still depends on {' and '.join(left)}" if left else share
