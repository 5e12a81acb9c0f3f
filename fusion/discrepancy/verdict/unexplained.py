"""Unexplained: how much of the depth stays wrong under the extended model, beyond noise, and in which recordings."""

from typing import Any

import numpy as np

from fusion.discrepancy.compared import beyond_noise, depth_per_native, recording_names
from fusion.discrepancy.explain import Explanation


def unexplained_of(found: Explanation) -> dict[str, Any]:
    """Root mean square [m] beyond noise and likely pose errors, and where: the worst recording first."""
    seen = found.compared
    after = seen.after
    white, metres, place = seen.white[1], seen.metres[1], after.place
    loose = (after.loose.scatter**2 + after.loose.drift**2) * after.looseness**2 * depth_per_native(seen.before) ** 2
    left: dict[str, float] = {}
    for number, name in recording_names(seen.before).items():
        own = place == number
        if own.any():
            left[name] = float(np.mean(loose[own])) + beyond_noise(white[own], metres[own])
    total = beyond_noise(white, metres) + float(np.mean(loose))
    worst = sorted((name for name in left if total > 0 and left[name] > 0), key=lambda name: -left[name])
    return {"rms_m": float(np.sqrt(total)), "recordings": worst, "chi2_per_dof": float(np.mean(white**2))}
