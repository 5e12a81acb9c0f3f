"""Intervals: how far fitted parameters may be off, by covariance, by recordings that disagree and by the law's form."""

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.decisions import FEWEST
from fusion.discrepancy.naming.evidence import inflation
from fusion.discrepancy.naming.heterogeneity import unevenness
from fusion.discrepancy.naming.refit import PartsFit

Vector = NDArray[np.float64]

ALONE = 4.0  # a recording without which the variance grows by more than this is the only one that tells


def spreads_of(fit: PartsFit) -> Vector:
    """Standard deviations (p,) of all weights and logarithms of shapes.

    The larger of the covariance's and the jackknife's: a size that differs over the data is not known better.
    """
    if not fit.parts:
        return np.zeros(0)
    variance = _by_chance(fit)
    for k, (part, (own, _)) in enumerate(zip(fit.parts, fit.places, strict=True)):
        variance[own] += (unevenness(fit, k) * part.weights) ** 2
    return np.asarray(np.sqrt(variance))


def _by_chance(fit: PartsFit) -> Vector:
    """Variances (p,) of what one draw of the noise, of the poses and of the recordings does.

    That of the covariance is scaled by how much the bulk of the residuals exceeds it; the jackknife leaves out each.
    """
    normal = fit.normal
    cov = np.linalg.inv(normal)
    own = np.diag(cov) * inflation(fit.white)
    place = fit.observations.replicate
    places = np.unique(place)
    if len(places) < FEWEST:
        return np.asarray(own)
    total = np.zeros(len(own))
    for g in places:
        rows = place == g
        J, rest = fit.columns[rows], fit.white[rows]
        without = np.linalg.pinv(normal - J.T @ J, hermitian=True)
        moved = without @ (J.T @ rest)
        known = np.diag(without) < ALONE * np.diag(cov)
        total += np.where(known, moved, 0.0) ** 2
    return np.asarray(np.maximum(own, total * (len(places) - 1) / len(places)))
