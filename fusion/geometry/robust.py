"""What a few values far off do not move."""

import numpy as np
from numpy.typing import NDArray

MAD_TO_STD = 1.4826  # median of absolute deviations to standard deviation, of a normal distribution
CUT = 4.685  # of Tukey's biweight (Holland and Welsch 1977)
# errors of neighbouring pixels are alike (filters, matching windows, fixed patterns): what one independent
# equation is worth, a guess until a recording's own noise correlation is measured
EFFECTIVE = 0.005
SURE = 5.0  # standard deviations from which a scan contradicts a camera, or that nothing was pushed
DOUBT = 3.0  # the same from which it is said


def robust_std(deviations: NDArray[np.floating]) -> float:
    """Standard deviation of a normal distribution whose deviations from its middle have the same median size."""
    return MAD_TO_STD * float(np.median(np.abs(deviations)))


def tukey(standardised: NDArray[np.float64], cut: float = CUT) -> NDArray[np.float64]:
    """Tukey's biweight of residuals in units of their scale (Holland and Welsch 1977): 0 beyond the cut."""
    inside = np.clip(1 - (standardised / cut) ** 2, 0, None)
    return inside**2
