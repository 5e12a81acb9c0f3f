"""What was told and the images contradict: a step is refused, a log is left out. Everything after would follow it."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError, TrackingError
from fusion.turntable.axis import Turns
from fusion.turntable.guess.beginning import POINTS_FIRST, begin
from fusion.turntable.pairs.edges import stack, thinned_view
from fusion.turntable.pairs.misfit import misfits
from fusion.turntable.views import ObjectView, Region

FRAMES = 12  # looked at
CLEARLY = 0.7  # the images' own turns must lower the misfit of neighbours to this share of what told ones leave
GOOD = 0.15  # misfit up to which turns are believed: 0.04 to 0.09 in scans, 0.26 where none was found
OTHER = (0.2, np.deg2rad(2))  # share of the step, and least difference, that make it another step
REACH = 0.02  # [m] of pairs: a camera that is not calibrated may lay them so far apart (guess)


def refuse_contradicted_step(views: Sequence[ObjectView], region: Region, step: float) -> None:
    """Compare the told step with what neighbouring views say by themselves.

    Args:
        views: of frames in a row.
        region: where the object is.
        step: as told [rad], of either sign.

    Raises:
        RecordingError: another step brings neighbouring views together clearly better.
    """
    try:
        used, _, shown, _, (axis, angles) = begin(list(views[:FRAMES]), region, None)
    except TrackingError:  # larger steps than it finds by itself: the told one is all that is known
        return
    seen, turns, gaps = stack(shown), np.diff(angles), np.diff(used)
    pairs = [(k, k + 1) for k in range(len(turns))]

    def misfit(tried: NDArray[np.float64]) -> float:
        return float(np.mean(misfits(seen, pairs, Turns(axis, tried), REACH)))

    own = abs(float(np.median(turns / gaps)))
    differs = abs(own - abs(step)) > max(OTHER[0] * abs(step), OTHER[1])
    left = misfit(turns)
    if differs and left < GOOD and left < CLEARLY * min(misfit(sign * step * gaps) for sign in (-1.0, 1.0)):
        raise RecordingError(
            "the images contradict the step",
            "--step",
            f"about {np.rad2deg(own):.1f} deg between frames",
            f"{np.rad2deg(step):g} deg, as told",
            "leave --step out or correct it (--force goes on all the same)",
        )


def neighbours_misfit(views: Sequence[ObjectView], turned: Turns) -> float:
    """How badly a motion (n frames, NaN where one has no place) brings neighbouring views together, 0 to 1 (median)."""
    known = np.flatnonzero(np.isfinite(turned.angles))
    seen = stack([thinned_view(views[int(k)], POINTS_FIRST) for k in known])
    pairs = [(k, k + 1) for k in range(len(known) - 1)]
    return float(np.median(misfits(seen, pairs, Turns(turned.axis, np.diff(turned.angles[known])), REACH)))


def rather_alone(views: Sequence[ObjectView], told: Turns, alone: Turns) -> bool:
    """Whether the images' own motion brings neighbouring views together clearly better than one that follows a log."""
    left = neighbours_misfit(views, alone)
    return left < GOOD and left < CLEARLY * neighbours_misfit(views, told)
