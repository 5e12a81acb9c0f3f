"""Extrapolation: do the claims, with sizes fitted elsewhere, hold in recordings beyond all others?"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.explain import Explanation, variables_of

Vector = NDArray[np.float64]

OUTER = 0.2  # of the recordings lie beyond
LEAST = 5  # recordings: fewer leave too little inside
VARIABLES = ("depth", "incidence", "time")


@dataclass(frozen=True)
class Beyond:
    """Recordings at one end of a variable, predicted from all others.

    Attributes:
        variable: name as in verdicts.
        low: mean of the variable from which on a recording took no part.
        before, after: their chi2 per tile without the claims, and with sizes from the others.
    """

    variable: str
    low: float
    before: float
    after: float

    def entry(self) -> dict[str, Any]:
        return {
            "variable": self.variable,
            "from": self.low,
            "chi2_per_dof_before": self.before,
            "chi2_per_dof_after": self.after,
        }


def extrapolated(found: Explanation) -> list[Beyond]:
    """The farthest, the steepest and the latest recordings, as the others predict them; [] without any claim."""
    columns = _columns(found)
    place = found.before.place
    recordings = np.unique(place)
    if not columns.shape[1] or len(recordings) < LEAST:
        return []
    out = []
    known = variables_of(found.before)
    for name in VARIABLES:
        if name not in known:
            continue
        means = np.array([known[name][place == g].mean() for g in recordings])
        low = float(np.quantile(means, 1 - OUTER))
        outer = np.isin(place, recordings[means >= low])
        if np.ptp(means) > 0 and 0 < outer.mean() < 0.5:
            out.append(Beyond(name, low, *_chi2(columns, found.white, outer)))
    return out


def _columns(found: Explanation) -> Vector:
    """(n, k) all that the claims may change, in units of the gauge; their shapes stay as they were found."""
    parts = [step.candidate.white for step in found.named.steps]
    if found.unknown and found.beyond is not None:
        parts.append(found.beyond.law.footprint[:, None])
    return np.concatenate(parts, axis=1) if parts else np.zeros((len(found.white), 0))


def _chi2(columns: Vector, white: Vector, outer: NDArray[np.bool_]) -> tuple[float, float]:
    own, rest = columns[~outer], white[~outer]
    normal = own.T @ own
    ridge = 1e-6 * np.trace(normal) / len(normal) * np.eye(len(normal))
    left = white[outer] - columns[outer] @ np.linalg.solve(normal + ridge, own.T @ rest)
    return float(np.mean(white[outer] ** 2)), float(np.mean(left**2))
