"""Two plain laws together that do nearly what one flexible law does: a part of a wave looks like a sloping line."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.naming.effect_part import EffectPart
from fusion.discrepancy.naming.refit import PartsFit
from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.discrepancy.naming.search.score import possible
from fusion.discrepancy.naming.search.space import Space

Vector = NDArray[np.float64]

AS_NEAR = 0.005  # of a cosine: less tells no pair from another
LOOK = 0.9  # cosine of the two laws together with the footprint of the one
PARTED = 3.0  # standard errors, recordings as replicates, from which on data tell them apart: a wrong name costs more


def like_two(fit: PartsFit, part: EffectPart, others: Sequence[Candidate], space: Space) -> tuple[Candidate, ...]:
    """The two plain laws that are nearest to a flexible one, where recordings do not clearly tell them apart.

    Plain: of one size and without a shape. A flexible law has a shape that was searched (a period, a time constant).
    """
    footprint = space.of(part.footprint)
    plain = [c for c in others if _plain(c)]
    seen = [space.of(c.white)[:, 0] for c in plain]
    found: list[tuple[float, tuple[Candidate, ...]]] = []
    for (a, one), (b, two) in combinations(zip(plain, seen, strict=True), 2):
        columns = np.column_stack([one, two])
        if a.name == b.name or not np.all(np.any(columns, axis=0)):
            continue
        weights = np.asarray(np.linalg.lstsq(columns, footprint, rcond=1e-9)[0], float)
        made = columns @ weights
        cosine = float(np.linalg.norm(made) / max(float(np.linalg.norm(footprint)), 1e-300))
        fits = possible(a, weights[:1]) and possible(b, weights[1:])
        if fits and cosine > LOOK and not _told_apart(fit, space.of(fit.white), footprint - made):
            found.append((cosine, (a, b)))
    nearest = max((cosine for cosine, _ in found), default=0.0)
    near = (pair for cosine, pair in found if cosine > nearest - AS_NEAR)
    # where one scene shows two laws alike, the one that depends on less stands for both
    return min(
        near, key=lambda pair: (sum(len(c.form.kind.variables) for c in pair), [c.name for c in pair]), default=()
    )


def _plain(candidate: Candidate) -> bool:
    """True for a law of one size and without a shape that acts everywhere."""
    form = candidate.form
    return candidate.columns.shape[1] == 1 and not form.fixed and not form.map and not candidate.where


def _told_apart(fit: PartsFit, left: Vector, lost: Vector) -> bool:
    """True when recordings agree that what the two laws cannot follow is there."""
    place = fit.observations.place
    # chi2 with the two laws less chi2 with the one, recording by recording
    worse = np.array([float((2 * left + lost)[place == g] @ lost[place == g]) for g in np.unique(place)])
    error = np.sqrt(len(worse)) * float(worse.std())
    return bool(worse.sum() > PARTED * error)
