"""Numbers that sum up signed distances: CONTRACT's blocks, the F-score, the histogram."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
WITHIN = ("0.001", "0.002", "0.005")  # [m]
_BINS = 81


def block(distances: Array) -> dict[str, Any]:
    """mean_signed, mean, rms, std, median, p95, max [m] and the shares within 1, 2, 5 mm; NaN without distances.

    `std` is about the signed mean; `mean`, `median`, `p95` and `max` are of the size.
    """
    away = np.abs(distances)
    names = ("mean_signed", "mean", "rms", "std", "median", "p95", "max")
    if not len(distances):
        return {name: float("nan") for name in names} | {"within": dict.fromkeys(WITHIN, float("nan"))}
    rms = np.sqrt(np.mean(np.square(distances)))
    values = (distances.mean(), away.mean(), rms, distances.std(), np.median(away), np.percentile(away, 95), away.max())
    numbers: dict[str, Any] = {name: float(value) for name, value in zip(names, values, strict=True)}
    return numbers | {"within": {limit: float(np.mean(away <= float(limit))) for limit in WITHIN}}


def fscore(accuracy: dict[str, Any], completeness: dict[str, Any]) -> dict[str, float]:
    """Harmonic mean of both directions' shares (Knapitsch et al. 2017), by limit [m]."""
    result = {}
    for limit in WITHIN:
        precision, recall = accuracy["within"][limit], completeness["within"][limit]
        total = precision + recall
        result[limit] = 2 * precision * recall / total if total else 0.0 * total
    return result


def histogram(distances: Array) -> dict[str, list[float]]:
    """Counts, and edges [m] about 0 that hold 99 %; the outermost bins count what lies beyond, too."""
    half = max(float(np.percentile(np.abs(distances), 99)), 1e-5) if len(distances) else 1e-3
    counts, edges = np.histogram(np.clip(distances, -half, half), bins=_BINS, range=(-half, half))
    return {"counts": counts.astype(float).tolist(), "edges": edges.tolist()}
