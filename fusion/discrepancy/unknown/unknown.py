"""Unknown: all that can be said of an effect that no entry of the catalogue explains."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference.tile_covariance import MeasuredTiles
from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.discrepancy.unknown.frame import LawFrame, frame_of
from fusion.discrepancy.unknown.law import UnknownLaw, law_of
from fusion.discrepancy.unknown.nearest import NearestEffect, nearest_of
from fusion.discrepancy.unknown.table import joined
from fusion.discrepancy.unknown.unrestricted import Group, UnrestrictedGain
from fusion.sensor.effects.readout.tabulated import Tabulated
from fusion.sensor.sensor import Sensor


@dataclass(frozen=True)
class Unknown:
    """An effect without a name: its law, to what it is fixed, the nearest entry of the catalogue."""

    law: UnknownLaw
    frame: LawFrame
    nearest: NearestEffect | None

    @property
    def unconfirmed(self) -> "Unknown":
        """The same where frames that took no part contradict it: it is told of, and not established."""
        return replace(self, law=replace(self.law, held_out=0.0))

    def added_to(self, sensor: Sensor) -> Sensor:
        """The sensor with the law as its table `tabulated`, so that it corrects and simulates at once."""
        own = sensor.effect("tabulated")
        table = joined(own, self.law.table) if isinstance(own, Tabulated) else self.law.table
        name = "values" if np.any(table.values) else "values_px"
        size = float(np.max(np.abs(np.asarray(getattr(table, name)))))
        better = sensor.having(table)
        # a table whose size is as uncertain as its height would not be undone
        std = {**sensor.std, ("tabulated", name): min(self.law.std, 0.9) * size}
        sources = {**sensor.sources, "tabulated": f"explained: {self.law.text}"}
        return replace(better, std=std, sources=sources)


def unknown_of(
    white: NDArray[np.float64],
    data: MeasuredTiles,
    found: UnrestrictedGain,
    candidates: Sequence[Candidate],
    groups: list[Group],
) -> Unknown:
    """What is behind a leftover (n,) of which smooth functions explain `found`."""
    observations, covariance = data
    law = law_of(white, observations, covariance, found)
    nearest = nearest_of(law, candidates, white, groups)
    return Unknown(law, frame_of(white, observations, covariance), nearest)
