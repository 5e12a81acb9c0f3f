"""In place: whether one formula of an unknown law explains more than the names found, and takes their place."""

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.naming.effect_part import is_field
from fusion.discrepancy.naming.naming import Named
from fusion.discrepancy.unknown.law import UnknownLaw

Vector = NDArray[np.float64]

# times what names explain that a formula must: maps follow anything, and so does a patchwork of several names of
# which one acts in a region only, so that freedom decides; a law with many weights of its own kind of form (steps, a
# polynomial) is likelier than any formula that does the same; several names or waves follow much; what one law lacks
# of a fifth more is a matter of its form
ANY, MANY, SEVERAL, ONE = 1.0, 1.02, 1.05, 1.2


def is_asked(named: Named) -> bool:
    """True where a formula could explain enough more than the names: all that they leave, but for the noise."""
    if not named.steps:
        return False
    left = float(named.white @ named.white) - len(named.white)
    return _margin(named) < ONE or left > (ONE - 1.0) * sum(step.gain for step in named.steps)


def explains_more(law: UnknownLaw, named: Named, white: Vector) -> bool:
    """True where a formula that new recordings show explains more than all names, each less what its freedom costs.

    Args:
        white: (n,) what both had to explain, in units of the covariance.
    """
    gain = float(white @ white - named.white @ named.white)
    score = gain - sum(step.price for step in named.steps)
    return law.simple and law.replicated and law.score > _margin(named) * score


def _margin(named: Named) -> float:
    names = {step.effect.name for step in named.steps}
    patchwork = len(names) > 1 and any(step.candidate.where for step in named.steps)
    if patchwork or any(step.candidate.form.map for step in named.steps):
        return ANY
    if any(is_field(step.candidate) for step in named.steps):
        return MANY
    return SEVERAL if len(named.steps) > 1 else ONE
