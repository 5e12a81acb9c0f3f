"""The fit: how well the extended model predicts what took no part in it, and how much stays wrong under it, where."""

import numpy as np

from fusion.discrepancy.compared import Compared, beyond_noise, depth_per_native, recording_names
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.extrapolation import extrapolated
from fusion.discrepancy.verdict.content import Fit, LooseSize, Unexplained


def fit_of(found: Explanation) -> Fit:
    """Misfits before and after, what follows no law, and how many frames there were."""
    loose = found.before.loose
    unit = "m" if found.before.patches[0].view.time_of_flight else "px"
    return Fit(
        heldout=found.held.fit(found.before.sensor, found.mean_sensor),
        extrapolation=tuple(extrapolated(found)),
        scatter=LooseSize(value=loose.scatter, unit=unit),
        drift=LooseSize(value=loose.drift, unit=unit),
        frames_fitted=sum(len(block.frames) for block in found.blocks),
        frames_heldout=sum(len(block.held.frames) for block in found.blocks if block.held),
    )


def unexplained_of(found: Explanation) -> Unexplained:
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
    chi2 = float(np.mean(white**2))
    return Unexplained(
        rms_m=float(np.sqrt(total)),
        recordings=tuple(worst),
        chi2_per_dof=chi2,
        suggested_rms_m=_suggested(found, float(np.mean(loose))),
    )


def _suggested(found: Explanation, loose: float) -> float | None:
    """The same [m] under the model with all that is likely; None where that is no model of its own.

    Args:
        loose: mean square [m^2] of errors that follow no law.
    """
    if found.named.suggested is None:
        return None
    seen = Compared(found.before, found.before.under(found.named.suggested), found.covariance, False)
    return float(np.sqrt(beyond_noise(seen.white[1], seen.metres[1]) + loose))
