"""Scatter: what differs from tile to tile beyond the gauge, and follows no law of the catalogue and no variable."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from fusion.discrepancy.gauge import Gauge
from fusion.discrepancy.naming.candidates import Candidate
from fusion.discrepancy.naming.step import inflation
from fusion.discrepancy.unknown.unrestricted import Group

MUCH = 4.0  # times the gauge's variance: real scenes (second bounces, bent boards, traced labels), not its own faults
MOST_COLUMNS = 0.7  # of the tiles: with more, what is left says nothing
FAINT = 1e-8  # of the largest direction: rounding


def scatter_of(
    white: NDArray[np.float64], gauge: Gauge, candidates: Sequence[Candidate], groups: Sequence[Group]
) -> float:
    """Standard deviation [native unit] of the tiles' own error; 0 where the gauge does without.

    All forms and all smooth functions together are taken out first, so that nothing that could have a name is called
    scatter; maps too, where there are recordings enough.

    Args:
        white: (n,) residual in units of the gauge.
    """
    if inflation(white) < MUCH:
        return 0.0
    basis = _taken_out(white, candidates, groups)
    if basis is None:
        return 0.0
    kept = 1.0 - basis.shape[1] / len(white)
    left = inflation(white - basis @ (basis.T @ white))
    if left < MUCH * kept:
        return 0.0
    # what a tile's own error becomes in units of the gauge: where all else is shared by neighbours, a multiple of it
    own = solve_triangular(gauge.root, np.eye(len(white)), lower=True, check_finite=False)
    own -= basis @ (basis.T @ own)
    return float(np.sqrt((left - kept) / np.median((own**2).sum(axis=1))))


def _taken_out(
    white: NDArray[np.float64], candidates: Sequence[Candidate], groups: Sequence[Group]
) -> NDArray[np.float64] | None:
    """(n, r) orthonormal columns of all that could have a name; None where there are too few tiles for that."""
    smooth = [g.basis for g in groups]
    # few recordings: maps with a square for nearly every tile would follow anything
    laws = [c for c in candidates if not c.form.map]
    # fewer still: of each name the form that explains most
    best: dict[str, Candidate] = {}
    for law in sorted(laws, key=lambda c: float(np.linalg.norm(c.basis.T @ white))):
        best[law.name] = law
    for some, more in ((candidates, smooth), (laws, smooth), (best.values(), smooth), (best.values(), [])):
        basis = _spanned([c.basis for c in some] + more)
        if basis.shape[1] <= MOST_COLUMNS * len(white):
            return basis
    return None


def _spanned(bases: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """(n, r) orthonormal columns that span all of them."""
    columns = np.concatenate(bases, axis=1)
    power, directions = np.linalg.eigh(columns.T @ columns)
    kept = power > FAINT * power[-1]
    return np.asarray(columns @ (directions[:, kept] / np.sqrt(power[kept])))
