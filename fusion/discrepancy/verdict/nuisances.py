"""Nuisances: how much worse than stated the setting of the recordings is, as the verdict tells it."""

import numpy as np

from fusion.discrepancy.compared import depth_per_native
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.inference.camera_file import file_error
from fusion.discrepancy.inference.shapes import bent_m, mesh_off
from fusion.discrepancy.verdict.content import Nuisances


def nuisances_of(found: Explanation) -> Nuisances:
    """Sizes that were found beside what was stated: factor on the errors of poses; shape and drift as depth [m]."""
    loose = found.before.loose
    drift = loose.drift * float(np.sqrt(np.mean(depth_per_native(found.before) ** 2)))
    pulled = found.covariance.pulled(found.white)
    scale, off = mesh_off(found.before, pulled)
    return Nuisances(
        pose_factor=loose.pose,
        shape_rms_m=bent_m(found.before, pulled),
        mesh_scale=scale,
        mesh_off_m=off,
        drift_rms_m=drift,
        camera_file=file_error(found.before, pulled),
    )
