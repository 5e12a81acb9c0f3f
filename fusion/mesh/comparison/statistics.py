"""Numbers that sum up signed distances: those of comparison.json, the F-score, the histogram."""

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.mesh import Mesh

Array = NDArray[np.float64]
WITHIN = ("0.001", "0.002", "0.005")  # [m] the same for all, so that comparisons can be compared
_BINS = 81


@dataclass(frozen=True)
class DistanceStatistics:
    """Signed distances in numbers [m]; NaN without distances.

    Attributes:
        mean_signed, std: of the distances; the others are of their size.
        within: share by limit [m].
    """

    mean_signed: float
    mean: float
    rms: float
    std: float
    median: float
    p95: float
    max: float
    within: dict[str, float]

    @classmethod
    def of(cls, distances: Array) -> "DistanceStatistics":
        """Of signed distances (n,) [m]."""
        away = np.abs(distances)
        if not len(distances):
            none = float("nan")
            return cls(none, none, none, none, none, none, none, dict.fromkeys(WITHIN, none))
        return cls(
            mean_signed=float(distances.mean()),
            mean=float(away.mean()),
            rms=float(np.sqrt(np.mean(np.square(distances)))),
            std=float(distances.std()),
            median=float(np.median(away)),
            p95=float(np.percentile(away, 95)),
            max=float(away.max()),
            within={limit: float(np.mean(away <= float(limit))) for limit in WITHIN},
        )


def fscore(accuracy: DistanceStatistics, completeness: DistanceStatistics) -> dict[str, float]:
    """Harmonic mean of both directions' shares (Knapitsch et al. 2017), by limit [m]."""
    result = {}
    for limit in WITHIN:
        precision, recall = accuracy.within[limit], completeness.within[limit]
        total = precision + recall
        result[limit] = 2 * precision * recall / total if total else 0.0 * total
    return result


def histogram(distances: Array) -> dict[str, list[float]]:
    """Counts, and edges [m] about 0 that hold 99 %; the outermost bins count what lies beyond, too."""
    half = max(float(np.percentile(np.abs(distances), 99)), 1e-5) if len(distances) else 1e-3
    counts, edges = np.histogram(np.clip(distances, -half, half), bins=_BINS, range=(-half, half))
    return {"counts": counts.astype(float).tolist(), "edges": edges.tolist()}


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
