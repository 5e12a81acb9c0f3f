"""A table of missing values as part of a sensor model that may have a table of its own."""

from dataclasses import replace
from typing import Any

import numpy as np

from fusion.discrepancy.unknown.table import joined
from fusion.sensor.effects.readout.tabulated import Tabulated
from fusion.sensor.sensor import Sensor
from fusion.sensor.table import interpolated


def having_losses(sensor: Sensor, more: Tabulated) -> Sensor:
    """The sensor with a table of missing values, beside those of its own table."""
    own = sensor.effect("tabulated")
    if not isinstance(own, Tabulated):
        return sensor.having(more)
    both = joined(own, more)
    mesh = dict(zip(both.variables, np.meshgrid(*both.grid, indexing="ij"), strict=True))
    lost: Any = 0.0
    for one in (own, more):
        if np.any(one.missing):
            lost = lost + interpolated(np.asarray(one.missing, float), one.grid, [mesh[name] for name in one.variables])
    return sensor.having(replace(both, missing=np.clip(lost, 0.0, 1.0)))
