"""What an unknown law may depend on: every variable of a table, as tiles see it."""

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.observe.observations import Observations
from fusion.sensor.effects.readout.tabulated import VARIABLES

Vector = NDArray[np.float64]

# tiles keep clear of depth edges, so a law of the distance to them is judged elsewhere
LEFT_OUT = ("edge",)


def law_variables(observations: Observations) -> dict[str, Vector]:
    """Tile means (n,) of all variables that are known and vary, in the units of verdicts."""
    out: dict[str, Vector] = {}
    flight = observations.patches[0].view.time_of_flight
    for name, of in VARIABLES.items():
        if name in LEFT_OUT or (name == "disparity" and flight):
            continue
        parts = []
        for patch in observations.patches:
            value = of(patch.depth, patch.view)
            if value is None or not np.any(np.isfinite(value)):
                break
            parts.append(patch.tiles.mean(np.asarray(value, float)))
        else:
            values = np.concatenate(parts)
            if np.ptp(values) > 1e-9 * (1 + np.abs(values).max()):
                out[name] = values
    return out
