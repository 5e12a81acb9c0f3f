"""How much of their error views share, told by how views of the same place differ (a variogram).

Two views of one vertex differ by what they do not share: half the mean square of that is the semivariance, which grows
with how far apart the views are, up to the whole variance (Matheron 1963; Cressie 1993, equation 2.4.1). What it lacks
near zero is the error that neighbours share, as frozen speckle makes it; it fades as exp(-apart / reach). What all
views share shows in no difference and is not in it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.certainty.looks import Looks

Array = NDArray[np.float64]
BINS = np.deg2rad([0, 2.5, 5, 7.5, 10, 15, 20, 30, 40, 55, 75, 100, 180.001])
REACHES = np.deg2rad([2, 4, 7, 12, 20, 35])  # that are tried
FEWEST = 200  # pairs that make a bin count
VERTICES = 3000  # that are asked: more say nothing new


@dataclass(frozen=True)
class Shared:
    """What the variance of a view at a place is made of."""

    share: float  # 0 to 1, of what neighbouring views share; the rest each view has for itself
    reach: float  # [rad] between views over which that fades to 1 / e
    spread: float  # standard deviation of a view, both parts [m]; NaN where too few pairs tell it

    def values(self) -> dict[str, float | None]:
        """For JSON."""
        spread = self.spread if np.isfinite(self.spread) else None
        return {"share": self.share, "reach_deg": float(np.rad2deg(self.reach)), "view_spread_m": spread}


NOTHING = Shared(0.0, float(REACHES[0]), float("nan"))


def shared_errors(looks: Looks) -> Shared:
    """What some vertices tell; nothing is shared where too few are seen by two views."""
    distance, half, count = variogram(looks)
    if len(distance) < 3:
        return NOTHING
    best, found = np.inf, NOTHING
    weight = np.sqrt(count / count.sum())
    # what fades over longer than the views lie apart cannot be told from what all of them share
    longest = max(distance.max() / 2, REACHES[0])
    for reach in REACHES[longest >= REACHES]:
        grown = np.column_stack([np.ones_like(distance), 1 - np.exp(-distance / reach)])
        own, shared = _positive(grown * weight[:, None], half * weight)
        misfit = float(np.sum((weight * (grown @ [own, shared] - half)) ** 2))
        if misfit < best * (1 - 1e-9):
            both = max(own + shared, 1e-30)
            best, found = misfit, Shared(shared / both, float(reach), float(np.sqrt(both)))
    return found


def variogram(looks: Looks) -> tuple[Array, Array, Array]:
    """Mean distance [rad], semivariance [m^2] and weight of the pairs of each bin, (b,) each.

    Pairs count as both views count in the surface: what oblique ones get wrong has little weight there.
    """
    share, off = looks.share().astype(float), looks.off.astype(float)
    square, weight, apart, pairs = np.zeros((4, len(BINS) - 1))
    for i in range(off.shape[1]):
        both = share[:, i + 1 :] * share[:, i : i + 1]
        place = np.clip(np.digitize(looks.apart[i, i + 1 :], BINS) - 1, 0, len(weight) - 1)
        np.add.at(square, place, np.sum(both * (off[:, i + 1 :] - off[:, i : i + 1]) ** 2, axis=0))
        np.add.at(weight, place, both.sum(axis=0))
        np.add.at(apart, place, both.sum(axis=0) * looks.apart[i, i + 1 :])
        np.add.at(pairs, place, (both > 0).sum(axis=0))
    enough = pairs >= FEWEST
    return apart[enough] / weight[enough], square[enough] / (2 * weight[enough]), weight[enough]


def _positive(A: Array, b: Array) -> tuple[float, float]:
    """Least squares of two unknowns that are no less than 0; scipy's would bring all of its optimisers along."""
    both, _, rank, _ = np.linalg.lstsq(A, b)
    if rank == 2 and (both >= 0).all():
        return float(both[0]), float(both[1])
    alone = np.maximum(A.T @ b, 0) / np.maximum(np.square(A).sum(axis=0), 1e-300)
    misfit = np.square(A * alone - b[:, None]).sum(axis=0)
    return (float(alone[0]), 0.0) if misfit[0] <= misfit[1] else (0.0, float(alone[1]))
