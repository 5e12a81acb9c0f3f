"""Extrapolation: do the claims, with sizes fitted elsewhere, hold in recordings beyond all others?"""

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from fusion.discrepancy.decisions import FEWEST
from fusion.discrepancy.explain import Explanation

Vector = NDArray[np.float64]

OUTER = 0.2  # of the recordings lie beyond
VARIABLES = ("depth", "incidence", "time")


class ExtrapolatedFit(Struct, frozen=True, kw_only=True):
    """Recordings at one end of a variable, predicted from all others, without and with the claims."""

    variable: str
    low: float = field(name="from")
    chi2_per_dof_before: float
    chi2_per_dof_after: float


def extrapolated(found: Explanation) -> list[ExtrapolatedFit]:
    """The farthest, the steepest and the latest recordings, as the others predict them; [] without any claim."""
    columns, room = _columns(found)
    place = found.before.place
    recordings = np.unique(place)
    if not columns.shape[1] or len(recordings) < FEWEST:
        return []
    out = []
    known = found.before.variables
    for name in VARIABLES:
        if name not in known:
            continue
        means = np.array([known[name][place == g].mean() for g in recordings])
        low = float(np.quantile(means, 1 - OUTER))
        outer = np.isin(place, recordings[means >= low])
        if np.ptp(means) > 0 and 0 < outer.mean() < 0.5:
            before, after = _chi2(columns, room, found.white, outer)
            fit = ExtrapolatedFit(variable=name, low=low, chi2_per_dof_before=before, chi2_per_dof_after=after)
            out.append(fit)
    return out


def _columns(found: Explanation) -> tuple[Vector, NDArray[np.bool_]]:
    """(n, k) all that the claims may change, in units of the covariance, and which (k,) are squares of a map."""
    parts = [step.candidate.white for step in found.named.steps]
    maps = [np.full(step.candidate.white.shape[1], bool(step.candidate.form.map)) for step in found.named.steps]
    if found.unknown and found.beyond is not None:
        parts.append(found.beyond.law.footprint[:, None])
        maps.append(np.zeros(1, bool))
    if not parts:
        return np.zeros((len(found.white), 0)), np.zeros(0, bool)
    return np.concatenate(parts, axis=1), np.concatenate(maps)


def _chi2(columns: Vector, room: NDArray[np.bool_], white: Vector, outer: NDArray[np.bool_]) -> tuple[float, float]:
    own, rest = columns[~outer], white[~outer]
    normal = own.T @ own
    ridge = np.full(len(normal), 1e-6 * np.trace(normal) / len(normal))
    # squares of a map that few recordings saw are held near nothing
    ridge[room] = np.median(np.diag(normal)[room]) if room.any() else 0.0
    left = white[outer] - columns[outer] @ np.linalg.solve(normal + np.diag(ridge), own.T @ rest)
    return float(np.mean(white[outer] ** 2)), float(np.mean(left**2))
