"""Scatter: what differs from tile to tile beyond the gauge, and follows no law of the catalogue and no variable."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

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
    basis = _spanned([c.basis for c in candidates] + [g.basis for g in groups])
    if basis.shape[1] > MOST_COLUMNS * len(white):
        # few recordings: maps with a square for nearly every tile would follow anything
        basis = _spanned([c.basis for c in candidates if not c.form.map] + [g.basis for g in groups])
    if basis.shape[1] > MOST_COLUMNS * len(white):
        return 0.0
    left = inflation(white - basis @ (basis.T @ white)) * len(white) / (len(white) - basis.shape[1])
    if left < MUCH:
        return 0.0
    # of the whole gauge, not of a tile's own noise alone: what real scenes leave is shared by neighbours in part, and
    # would be taken for laws if it counted as independent from tile to tile
    own = float(np.median(np.linalg.norm(gauge.bare, axis=1)))
    return float(np.sqrt(left - 1.0)) * own


def _spanned(bases: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """(n, r) orthonormal columns that span all of them."""
    columns = np.concatenate(bases, axis=1)
    power, directions = np.linalg.eigh(columns.T @ columns)
    kept = power > FAINT * power[-1]
    return np.asarray(columns @ (directions[:, kept] / np.sqrt(power[kept])))
