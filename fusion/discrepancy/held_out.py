"""Held out: frames that take no part in any fit, and how well a sensor model predicts their mean."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fusion.discrepancy.gauge import Gauge, gauge_of
from fusion.discrepancy.look import Look
from fusion.discrepancy.observations import Observations, observe
from fusion.sensor.sensor import Sensor


@dataclass(frozen=True)
class HeldOut:
    """Frames that were set aside before any residual was looked at.

    Attributes:
        observations: of these frames under the given model; None where there are none.
    """

    observations: Observations | None

    @cached_property
    def gauge(self) -> Gauge:
        assert self.observations is not None
        return gauge_of(self.observations)

    def misfit(self, sensor: Sensor) -> tuple[float, float]:
        """Chi2 per tile and rms [m] of what a model leaves; NaN without such frames."""
        if self.observations is None:
            return float("nan"), float("nan")
        seen = self.observations.under(sensor)
        white = self.gauge.whiten(seen.residual)
        metres = np.concatenate([p.tiles.mean(p.look.mean - p.predicted) for p in seen.patches])
        return float(white @ white / len(white)), float(np.sqrt(np.mean(metres**2)))

    def contradicts(self, better: Sensor, than: Sensor | None = None) -> bool:
        """True when a model that fitted the other frames better fits these no better `than` another, else the given."""
        if self.observations is None:
            return False
        return self.misfit(better)[0] >= self.misfit(than or self.observations.sensor)[0]


def held_out_of(looks: Sequence[Look], sensor: Sensor, scatter: float = 0.0) -> HeldOut:
    """The frames held out of looks, under the given model; `scatter` as of the others."""
    held = [look.held for look in looks if look.held is not None]
    seen = observe(sensor, held) if held else None
    return HeldOut(replace(seen, scatter=scatter) if seen is not None and len(seen.residual) else None)


def before_and_after(held: HeldOut, sensor: Sensor, better: Sensor) -> dict[str, float]:
    """As it stands in a verdict."""
    (chi2, rms), (chi2_after, rms_after) = held.misfit(sensor), held.misfit(better)
    return {
        "chi2_per_dof_before": chi2,
        "chi2_per_dof_after": chi2_after,
        "rms_before_m": rms,
        "rms_after_m": rms_after,
    }
