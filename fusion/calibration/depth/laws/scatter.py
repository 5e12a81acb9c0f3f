"""How much more the walls scatter about a law than the stated deviations of their distances allow."""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import chdtrc

from fusion.calibration.depth.laws.information import WallEvidence

UNLIKELY = 0.05
MOST = 1.0  # [m]
Array = NDArray[np.floating]


def excess(evidence: list[WallEvidence], rests: list[Array], numbers: int) -> float:
    """Standard deviation [m] that every wall's distance has beyond the stated one; 0 when there may be none.

    It is added to the stated ones in squares: what spoils distances (a board of another size or bent, a phase that is
    off) knows nothing of how well a laser or a camera could have told them.

    Args:
        evidence: of the walls, with the deviations as stated.
        rests: per wall (t,) [m] what a law leaves over.
        numbers: how many numbers of the law the distances alone can tell.
    """
    off, variance = [], []
    for e, rest in zip(evidence, rests, strict=True):
        if np.isfinite(e.distance_std):
            w = 1 / np.sqrt(e.variance)
            G = e.nuisances * w[:, None]
            off.append(float(np.linalg.lstsq(G, rest * w, rcond=None)[0][2]))
            variance.append(e.wall.distance_std**2 + float(np.linalg.inv(G.T @ G)[2, 2]))
    freedom = len(off) - numbers
    squares, known = np.square(off), np.array(variance)
    if freedom < 2 or chdtrc(freedom, float((squares / known).sum())) > UNLIKELY:
        return 0.0
    return float(brentq(lambda s: float((squares / (known + s * s)).sum()) - freedom, 0.0, MOST))
