"""Score: what a candidate explains of a vector, less what its freedom costs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.naming.effect_part import FIELD
from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.sensor.parameter import parameters

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

FAINT = 1e-10  # of the largest eigenvalue: rounding
SIZES = np.geomspace(1e-2, 1e3, 31)  # of a field's weights, over the one that noise alone would give


@dataclass(frozen=True)
class Scored:
    """What a candidate would bring."""

    gain: float  # drop of the chi2 with free weights
    score: float  # the same less the price of the weights, for comparison with others
    weights: Vector  # (k,) of the atoms
    size: float  # of the weights of a field, 0 for others
    freedom: int  # number of independent weights


def scored(candidate: Candidate, white: Matrix, target: Vector) -> Scored:
    """Score of a candidate whose columns (n, k) and target (n,) are given in the same space.

    Few weights pay the logarithm of the number of tiles each. The many of a field are draws of one size: they pay
    what that size leaves open.
    """
    n = len(target)
    values, vectors = np.linalg.eigh(white.T @ white)
    if not len(values) or values[-1] <= 0:
        return Scored(0.0, -np.inf, np.zeros(white.shape[1]), 0.0, 0)
    seen = values > FAINT * max(float(values[-1]), 1e-300)
    values, vectors = values[seen], vectors[:, seen]
    along = vectors.T @ (white.T @ target)
    power = along**2 / values
    weights = vectors @ (along / values)
    gain = float(power.sum())
    if white.shape[1] < FIELD:
        can_be = possible(candidate, weights)
        return Scored(gain, gain - len(values) * float(np.log(n)) if can_be else -np.inf, weights, 0.0, len(values))
    size, evidence = usual_size(values, power)
    shrunk = vectors @ (along / (values + size**-2))
    return Scored(gain, evidence - float(np.log(n)), shrunk, size, len(values))


def usual_size(values: Vector, power: Vector) -> tuple[float, float]:
    """The usual size of weights that are draws of one size, and the chi2 by which it is likelier than none.

    Args:
        values: (k,) eigenvalues of the columns' products, above 0.
        power: (k,) chi2 that each of these directions explains.
    """
    t = SIZES[:, None] ** 2 * values[None] / float(np.median(values))
    evidence = (power * t / (1 + t) - np.log1p(t)).sum(axis=1)
    best = int(np.argmax(evidence))
    return float(SIZES[best] / np.sqrt(np.median(values))), float(evidence[best])


def possible(candidate: Candidate, weights: Vector) -> bool:
    """False where a single weight has a sign that the parameter cannot have."""
    form = candidate.form
    if len(weights) != 1 or form.map:
        return True
    about = parameters(form.kind)
    signs = [
        (about[name], float(np.sum(value)) * float(weights[0]))
        for name, value in form.atoms[0].items()
        if name in about and about[name].neutral == 0
    ]
    return all(p.low < 0 or value >= 0 for p, value in signs) and all(p.high > 0 or value <= 0 for p, value in signs)
