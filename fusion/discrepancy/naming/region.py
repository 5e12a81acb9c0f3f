"""Where an effect acts: everywhere, or only in a part of the data."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

CUTS = 24  # thresholds that are tried along each variable
LEAST_SHARE = 0.1  # of the tiles on both sides of a threshold
BETTER = 0.04  # of the gain: a region must explain that much more than the whole
FAINT = 0.35  # of the size inside: outside a region the effect must be below


@dataclass(frozen=True)
class Region:
    """One side of one variable.

    Attributes:
        variable: name as in verdicts.
        low, high: bounds; one of them infinite.
    """

    variable: str
    low: float
    high: float


def region_of(white: Vector, footprint: Vector, covariates: dict[str, Vector]) -> Region | None:
    """The part of the data to which a footprint (n,) is confined, or None when it acts everywhere.

    Args:
        white: (n,) residual before the effect was added, whitened.
        footprint: (n,) what the effect changes, whitened, at any size.
        covariates: (n,) each.
    """
    whole = _gain(white, footprint)
    best, chosen = whole * (1 + BETTER) + 12.0, None
    for name, values in covariates.items():
        for cut in np.unique(np.quantile(values, np.linspace(LEAST_SHARE, 1 - LEAST_SHARE, CUTS))):
            for inside, region in (
                (values >= cut, Region(name, float(cut), np.inf)),
                (values <= cut, Region(name, -np.inf, float(cut))),
            ):
                if not LEAST_SHARE < inside.mean() < 1 - LEAST_SHARE:
                    continue
                gain = _gain(white[inside], footprint[inside])
                if gain > best and abs(_size(white[~inside], footprint[~inside])) < FAINT * abs(
                    _size(white[inside], footprint[inside])
                ):
                    best, chosen = gain, region
    return chosen


def _gain(white: Vector, footprint: Vector) -> float:
    power = float(footprint @ footprint)
    return float((footprint @ white) ** 2 / power) if power > 0 else 0.0


def _size(white: Vector, footprint: Vector) -> float:
    power = float(footprint @ footprint)
    return float(footprint @ white) / power if power > 0 else 0.0
