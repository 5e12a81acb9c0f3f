"""Deviations beside what a scan can know: its distances in units of the standard deviation that each vertex carries."""

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.mesh import Mesh

SIGMA = "sigma"  # scalar of a mesh: standard deviation of a vertex along its normal [m]
OVER = "deviation_over_sigma"  # scalar of a compared mesh [1]
NINETY, FAR = 1.645, 3.0  # standard deviations: 90 % of normal errors stay below, 99.7 % do


@dataclass(frozen=True)
class Knowable:
    """What of the deviations the scan's own uncertainty explains."""

    vertices: int  # with a sigma and a distance
    within_90: float  # share of them within 1.645 sigma; 0.9 where nothing but the scan's own errors is seen
    # share of them beyond 3 sigma: there scan and reference differ by more than the scan can know
    beyond_3_sigma: float
    sigma_median: float  # [m]

    def values(self) -> dict[str, float]:
        """For JSON."""
        told = asdict(self)
        return {"sigma_median_m": told.pop("sigma_median")} | told


def over_sigma(mesh: Mesh, distances: NDArray[np.floating], scale: float = 1.0) -> NDArray[np.float32] | None:
    """(n,) distances over sigma, NaN where either is not known; None where the mesh carries no sigma.

    Args:
        mesh: with the scalar `sigma`, before it was multiplied.
        distances: (n,) signed [m].
        scale: what the mesh was multiplied with.
    """
    sigma = mesh.scalars.get(SIGMA)
    if sigma is None:
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(sigma > 0, distances / (scale * sigma), np.nan).astype(np.float32)


def knowable(mesh: Mesh) -> Knowable | None:
    """Sums up the scalars of a compared mesh; None where it carries no sigma."""
    over = mesh.scalars.get(OVER)
    if over is None or not np.isfinite(over).any():
        return None
    known = np.abs(over[np.isfinite(over)])
    middle = float(np.median(mesh.scalars[SIGMA][np.isfinite(over)]))
    return Knowable(len(known), float(np.mean(known <= NINETY)), float(np.mean(known > FAR)), middle)
