"""Numbers that sum up signed distances: CONTRACT's blocks, the F-score, the histogram."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
