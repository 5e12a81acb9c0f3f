"""Which form a lens has: three radial terms, or the rational form's six, by views left out."""

from collections.abc import Sequence

import numpy as np

from fusion.calibration.lens.fit.solve import placed, residual, solve
from fusion.calibration.lens.views import BoardView
from fusion.errors import RecordingError
from fusion.geometry.pose import Array
from fusion.geometry.robust import robust_std

FOLDS = 5
FEWEST = 10  # views: a fold leaves out two or more
BETTER = 0.9  # of the misfit on views left out
SURE = 3.0  # standard errors over the views


def is_rational(views: Sequence[BoardView], size: tuple[int, int]) -> bool:
    """True where twelve parameters predict views left out clearly better than nine.

    Args:
        views: of the board; a few may be wrong: what most views say counts.
    """
    if len(views) < FEWEST:
        return False
    try:
        plain, wide = (_left_out(views, size, rational) for rational in (False, True))
    except RecordingError:  # told where the camera is fitted
        return False
    gain = np.log(wide / plain)
    gain = gain[np.isfinite(gain)]
    if len(gain) < FEWEST:
        return False
    middle = float(np.median(gain))
    spread = robust_std(gain - middle) / np.sqrt(len(gain))
    return middle < np.log(BETTER) and middle < -SURE * spread


def _left_out(views: Sequence[BoardView], size: tuple[int, int], rational: bool) -> Array:
    """(views,) misfit [px] of each under a camera that was fitted without it; NaN where it has no pose."""
    misfit = np.full(len(views), np.nan)
    for fold in range(FOLDS):
        camera = solve([view for i, view in enumerate(views) if i % FOLDS != fold], size, rational=rational).parameters
        for i in range(fold, len(views), FOLDS):
            pose = placed(views[i], camera)
            if pose is not None:
                misfit[i] = np.sqrt((residual(views[i], pose, camera) ** 2).mean())
    return misfit
