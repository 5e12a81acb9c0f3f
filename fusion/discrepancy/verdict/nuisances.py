"""Nuisances: how much worse than stated the setting of the recordings is, as the verdict tells it."""

from typing import Any

import numpy as np

from fusion.discrepancy.compared import depth_per_native
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.shapes import bent_m


def nuisances_of(found: Explanation) -> dict[str, Any]:
    """Sizes that were found beside what was stated: factor on the errors of poses; shape and drift as depth [m]."""
    loose = found.before.loose
    drift = loose.drift * float(np.sqrt(np.mean(depth_per_native(found.before) ** 2)))
    bent = bent_m(found.before, found.gauge.pulled(found.white))
    return {"pose_factor": loose.pose, "shape_rms_m": bent, "drift_rms_m": drift}
