"""Unexplained: how much of the depth stays wrong under the extended model, beyond noise, and in which recordings."""

from typing import Any

import numpy as np

from fusion.discrepancy.compared import depth_per_native, recording_names
from fusion.discrepancy.explain import Explanation

NOISE_ALONE = 1.3  # chi2 per tile up to which a recording shows noise and nothing else (guess)


def unexplained_of(found: Explanation) -> dict[str, Any]:
    """Root mean square [m] beyond noise and likely pose errors, and where: the worst recording first."""
    seen = found.compared
    after = seen.after
    white, metres, place = seen.white[1], seen.metres[1], after.place
    loose = (after.scatter**2 + after.drift**2) * after.looseness**2 * depth_per_native(seen.before) ** 2
    left: dict[str, float] = {}
    for number, name in recording_names(seen.before).items():
        own = place == number
        if own.any():
            left[name] = float(np.mean(loose[own])) + _beyond(white[own], metres[own])
    total = _beyond(white, metres) + float(np.mean(loose))
    worst = sorted((name for name in left if total > 0 and left[name] > 0), key=lambda name: -left[name])
    return {"rms_m": float(np.sqrt(total)), "recordings": worst, "chi2_per_dof": float(np.mean(white**2))}


def _beyond(white: np.ndarray, metres: np.ndarray) -> float:
    """Mean square [m^2] of residuals that their noise does not explain; 0 where noise alone is that large."""
    chi2 = float(np.mean(white**2))
    return 0.0 if chi2 <= NOISE_ALONE else float(np.mean(metres**2)) * (1.0 - 1.0 / chi2)
