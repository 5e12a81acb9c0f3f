"""All turns of a scan brought together, and what they say of the camera."""

import numpy as np
from numpy.typing import NDArray

from fusion.turntable.all_views.camera_fit import misfit
from fusion.turntable.all_views.log import of_its_sign
from fusion.turntable.all_views.loop import COARSE_POINTS, Loop, LoopSettings, choose_edges, close_loop
from fusion.turntable.axis import Turns
from fusion.turntable.pairs.edges import ViewStack
from fusion.turntable.pairs.misfit import misfits
from fusion.turntable.selfcheck import DEPTH, SelfCheck

Array = NDArray[np.float64]
# [m] of the first passes; absolute: with shares of the object, tried for all lengths at once, wrong steps passed
REACH = 0.03
WIDEST = np.deg2rad(50)  # between two views that are compared
TILTS = ("tilt_u", "tilt_v")
# by a calibration of time of flight: a lamp beside the lens tilts its depth by centimetres over the image, and walls at
# a free tilt do not show it. What a calibration of triangulation leaves is less than what its windows imitate
LEFT_OPEN = DEPTH
OTHER = np.deg2rad(1.0)  # between two beginnings that are worth trying both


def together(
    shown: ViewStack, guess: Turns, check: SelfCheck, commanded: Array | None = None
) -> tuple[Loop, list[tuple[int, int]]]:
    """All turns brought together with the focal length free, and the pairs of views that overlap then.

    Args:
        shown: the views.
        guess: first, angles (n,) [rad].
        check: errors of camera and depth to begin with, see `no_errors`.
        commanded: (n,) what the table was told [rad], of either sign; the fit begins there too, and the better
            beginning is gone on with: errors that stand still in the image may have pulled the first guess.
    """
    told = None if commanded is None else of_its_sign(guess.angles, commanded)
    coarse = LoopSettings((REACH, 0.015, 0.01), (3, 3, 4), free_camera=("focal",), told=told)
    some = shown.thinned(COARSE_POINTS)
    first = _begun(some, guess, coarse, check)
    if told is not None and np.ptp(guess.angles - told) > OTHER:
        first = min(first, _begun(some, Turns(guess.axis, told), coarse, check), key=misfit)
    angles = _close_turns(some, first)
    edges = choose_edges(angles, WIDEST, 4)
    middle = close_loop(some, Turns(first.axis, angles), edges, coarse, first.check)
    return middle, choose_edges(middle.angles, WIDEST, 4)


def _begun(seen: ViewStack, motion: Turns, settings: LoopSettings, check: SelfCheck) -> Loop:
    """The turns one after the other from a first guess."""
    # partners of other turns may be nearer than all of the same one
    return close_loop(seen, motion, choose_edges(motion.angles, per_frame=4, farthest=np.pi), settings, check)


def _close_turns(seen: ViewStack, fit: Loop) -> Array:
    """Stretch the angles so that views of different turns (or across the gap) agree: undoes a bias of every step."""
    i, j = np.triu_indices(len(fit.angles), 1)
    far = np.abs(fit.angles[j] - fit.angles[i]) > np.pi
    i, j = i[far], j[far]
    tries = np.append(np.linspace(0.88, 1.16, 57), 1.0)
    turns = (np.multiply.outer(tries, fit.angles[j] - fit.angles[i]) + np.pi) % (2 * np.pi) - np.pi
    picks: list[tuple[int, int]] = []  # a try, and a pair of views that are near each other then
    for k, near in enumerate(np.abs(turns) < np.deg2rad(40)):
        where = np.flatnonzero(near)
        some = where[np.linspace(0, len(where) - 1, min(24, len(where))).astype(int)]
        picks.extend((k, int(pair)) for pair in some)
    if not picks:
        return fit.angles
    which, pair = np.array(picks).T
    edges = list(zip(i[pair].tolist(), j[pair].tolist(), strict=True))
    wrong = misfits(seen, edges, Turns(fit.axis, turns[which, pair]), REACH, fit.check)
    count = np.bincount(which, minlength=len(tries))
    values = np.where(count > 0, np.bincount(which, wrong, len(tries)) / np.maximum(count, 1), 1.0)
    best, stay = float(tries[int(np.argmin(values))]), values[-1]
    return fit.angles * best if values.min() < 0.8 * stay else fit.angles
