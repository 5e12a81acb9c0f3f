"""Spreads that a few values far off do not move."""

import numpy as np
from numpy.typing import NDArray

MAD_TO_STD = 1.4826  # median of absolute deviations to standard deviation, of a normal distribution


def robust_std(deviations: NDArray[np.floating]) -> float:
    """Standard deviation of a normal distribution whose deviations from its middle have the same median size."""
    return MAD_TO_STD * float(np.median(np.abs(deviations)))
