"""Beside: what one part of a fit has to explain when all others stay."""

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.naming.refit import PartsFit
from fusion.discrepancy.naming.search.space import Aim, space_beside

Vector = NDArray[np.float64]


def partial_residual(fit: PartsFit, k: int | None) -> Aim:
    """What stays to be explained beside the parts (without part k), and the residual there (with part k's share)."""
    parts, shapes = fit.others(k)
    space = space_beside(parts, shapes, len(fit.white))
    residual = fit.white if k is None else fit.white + fit.parts[k].footprint
    return Aim(space, np.asarray(space.of(residual)))
