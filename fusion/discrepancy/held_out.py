"""Held out: frames that take no part in any fit, and how well a sensor model predicts their mean."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from msgspec import Struct

from fusion.discrepancy.decisions import REPLICATED
from fusion.discrepancy.inference.tile_covariance import TileCovariance, covariance_of
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.observations import Observations, observe
from fusion.sensor.sensor import Sensor


class HeldOutFit(Struct, frozen=True, kw_only=True):
    """Frames that took no part in the fit, without and with the claims; null where there are none."""

    chi2_per_dof_before: float | None
    chi2_per_dof_after: float | None
    rms_before_m: float | None
    rms_after_m: float | None


@dataclass(frozen=True)
class HeldOut:
    """Frames that were set aside before any residual was looked at."""

    observations: Observations | None  # of these frames under the given model; None where there are none
    share: float = 0.0  # their number over that of the other frames

    @cached_property
    def covariance(self) -> TileCovariance:
        assert self.observations is not None
        return covariance_of(self.observations)

    def misfit(self, sensor: Sensor) -> tuple[float, float]:
        """Chi2 per tile and rms [m] of what a model leaves; NaN without such frames."""
        if self.observations is None:
            return float("nan"), float("nan")
        seen = self.observations.under(sensor)
        white = self.covariance.whiten(seen.residual)
        metres = np.concatenate([p.tiles.mean(p.block.mean - p.predicted) for p in seen.patches])
        return float(white @ white / len(white)), float(np.sqrt(np.mean(metres**2)))

    def fit(self, given: Sensor, better: Sensor) -> HeldOutFit:
        """How well a model foresees these frames, and a better one."""
        known = [value if np.isfinite(value) else None for model in (given, better) for value in self.misfit(model)]
        chi2, rms, chi2_after, rms_after = known
        return HeldOutFit(
            chi2_per_dof_before=chi2, chi2_per_dof_after=chi2_after, rms_before_m=rms, rms_after_m=rms_after
        )

    def contradicts(self, better: Sensor, gain: float, than: Sensor | None = None) -> bool:
        """True when a model that fitted the other frames better does not fit these better by a fair share of it.

        Args:
            gain: drop of the chi2 in the other frames.
            than: what it is compared with; the given model where nothing is said.
        """
        if self.observations is None:
            return False
        before, after = self.misfit(than or self.observations.sensor)[0], self.misfit(better)[0]
        # where the noise of frames rules, their number tells; a drop of the chi2 is known to twice its root
        due = self.share * gain
        return (before - after) * len(self.observations.residual) <= max(0.0, REPLICATED * due - 2 * np.sqrt(due))


def held_out_of(blocks: Sequence[FrameBlock], sensor: Sensor, others: Observations | None = None) -> HeldOut:
    """The frames held out of blocks, under the given model; with the scatter and the drift of the others."""
    held = [block.held for block in blocks if block.held is not None]
    seen = observe(sensor, held) if held else None
    share = sum(len(block.frames) for block in held) / max(sum(len(block.frames) for block in blocks), 1)
    if seen is None or not len(seen.residual):
        return HeldOut(None, share)
    return HeldOut(seen if others is None else replace(seen, loose=others.loose), share)
