"""Uneven: by how much the size of a part differs from place to place in the data, beyond chance.

A law whose form is right has one size everywhere. Where the form is only nearly right, the size that fits is another
one near and far, in the middle and at the border, in this recording and in that: then no number of tiles makes the
size better known than it differs.
"""

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.naming.evidence import inflation
from fusion.discrepancy.naming.refit import PartsFit, partial_residual
from fusion.discrepancy.naming.search.score import usual_size
from fusion.discrepancy.unknown.unrestricted import covariates

Vector = NDArray[np.float64]

FORM = 0.01  # of a gain, a tenth of its size: no law of a catalogue is known better than that
CLEARLY = 1.5  # times what a size that differs would explain: another cause explained twice to 25 times that
CHANCE = 2.7  # evidence for a spread that chance alone gives in one case of twenty: half a chi2 of one number


def form_of(fit: PartsFit, k: int) -> float:
    """Share of the gain of part k that may be a matter of its form.

    Were its size to differ over the data, that would explain as much: its form is known no better.
    """
    return max(FORM, CLEARLY * unevenness(fit, k) ** 2)


def unevenness(fit: PartsFit, k: int) -> float:
    """Standard deviation of the local size of part k over the tiles, as a share of it; 0 where one size will do."""
    part = fit.parts[k]
    weight = part.footprint**2
    if part.size or not weight.any():
        return 0.0  # a map has a size of its own for each of its squares
    ways = _ways(fit, weight / weight.sum())
    space, target = partial_residual(fit, None)
    change = (part.candidate.columns @ part.weights)[:, None] * ways
    noise = np.sqrt(inflation(target))
    seen, rest = space.of(fit.covariance.whiten(change)) / noise, target / noise
    values, vectors = np.linalg.eigh(seen.T @ seen)
    told = values > 1e-9 * values[-1]
    values, vectors = values[told], vectors[:, told]
    along = vectors.T @ (seen.T @ rest)
    size, evidence = usual_size(values, along**2 / values)
    if evidence < CHANCE:
        return 0.0
    local = ways @ (vectors @ (along / (values + size**-2)))
    return float(np.sqrt(weight @ local**2 / weight.sum()))


def _ways(fit: PartsFit, weight: Vector) -> NDArray[np.float64]:
    """(n, k) ways in which a size may differ: along each variable, to one side or to both ends, and by recording.

    Their mean over the tiles is 0 and their spread 1, each tile with its weight (n,).
    """
    place, ways = fit.observations.replicate, []
    for values in covariates(fit.observations).values():
        rank = np.searchsorted(np.sort(values), values) / len(values) - 0.5
        ways += [rank, rank**2]
    ways += [(place == g).astype(float) for g in np.unique(place)]
    columns = np.column_stack(ways) - weight @ np.column_stack(ways)
    spread = np.sqrt(weight @ columns**2)
    return np.asarray(columns[:, spread > 1e-6] / spread[spread > 1e-6])
