"""Errors of camera and depth that the turns of all views show, and whether they are believed."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.robust import DOUBT, EFFECTIVE, SURE
from fusion.turntable.all_views.loop import Loop, LoopSettings, close_loop
from fusion.turntable.axis import Turns
from fusion.turntable.pairs.edges import ViewStack
from fusion.turntable.selfcheck import LENS, PRIOR

SYSTEMATIC = 0.002  # of the focal length: what an unstated lens does to such a fit (guess)
DEPTH_ERRORS = ("offset", "radial", "bend2", "bend3", "bend4", "bend5", "bend6")

Array = NDArray[np.float64]

WORTH = 0.98  # by how much more errors of camera or depth must lower the misfit to be believed (guess)


def fit_camera(
    shown: ViewStack,
    middle: Loop,
    edges: list[tuple[int, int]],
    told: Array | None = None,
    left_open: tuple[str, ...] = (),
) -> Loop:
    """The fit with focal length and principal point free, and errors of depth too where the scan asks for them.

    Errors of depth that change with distance or over the image bend an object much as a wrong focal length does. Where
    they explain clearly more, the focal length is what is left beside them, with the wider spread that belongs to it:
    on the three open challenges, stated and true camera, it is then within 2 of its standard deviations of the truth,
    where the camera alone was up to 27 off.

    Args:
        left_open: errors of depth that a calibration leaves open; empty for a depth as it is given.

    What a calibration says of the lens is left out here, as the scan is asked about it; what it says of the depth
    counts.
    """
    # stretch stays out: noise in pairs of views imitates it, and it does nearly what a focal length does
    errors = tuple(name for name in left_open or DEPTH_ERRORS if name != "stretch")
    start = replace(middle.check, prior=np.append(PRIOR[: len(LENS)], middle.check.prior[len(LENS) :]))
    # to its end: stopped early it leaves to the errors of depth what is the camera's
    alone = close_loop(shown, Turns(middle.axis, middle.angles), edges, _passes(LENS, 15, told), start)
    both = close_loop(shown, Turns(alone.axis, alone.angles), edges, _passes(LENS + errors, 5, told), alone.check)
    found = both if believed(both, alone) else alone
    if abs(found.check.values[0]) <= DOUBT * found.check_std[0]:
        return found
    clear = close_loop(shown.clear(), Turns(middle.axis, middle.angles), edges, _passes(LENS, 15, told), start)
    if not rests_on_rims(float(found.check.values[0]), float(clear.check.values[0]), float(clear.check_std[0])):
        return found
    std = found.check_std.copy()
    std[0] = max(std[0], abs(found.check.values[0]))  # as good as nothing
    return replace(found, check_std=std)


def rests_on_rims(focal: float, clear: float, clear_std: float) -> bool:
    """Whether it is only its rims by which an object asks for another focal length, a relative change.

    Pixels of a rim mix what is before with what is behind, so that it stands by part of a pixel elsewhere: of a round
    thing with a radius of 20 pixels that looks like a focal length 4 % off, as sure as rims are sharp.

    Args:
        clear, clear_std: what the surface that is seen clearly asks for, and its standard deviation.
    """
    return bool(clear_std > abs(focal) or clear * np.sign(focal) < abs(focal) / 2)


def contradicts(fit: Loop) -> bool:
    """Whether a fit asks for another focal length as surely as a scan that is tried with it has to.

    Blur bends a cylinder as a focal length does, by 2 % at 3 standard deviations (tools/sets/hard_scans, seed 408):
    what is less sure does not bend the motion either.
    """
    return bool(abs(fit.check.values[0]) > SURE * np.hypot(fit.check_std[0], SYSTEMATIC))


def _passes(free: tuple[str, ...], iterations: int, told: Array | None) -> LoopSettings:
    return LoopSettings((0.01, 0.008), (iterations, iterations), free_camera=free, told=told)


def misfit(fit: Loop) -> float:
    """Residual over support [m]: a fit that leaves surface out is no better."""
    return float(np.median(fit.residual)) / max(float(np.median(fit.support)), 1e-3)


def believed(fit: Loop, than: Loop) -> bool:
    """Whether more errors of camera or depth pay for themselves: in misfit, and by Schwarz's criterion (1978).

    They cost precision, and without them the model of all frames makes the motion better (see `finish`). What pairs of
    points are worth together is what the fit itself takes them for.
    """
    if misfit(fit) == 0:  # no pair is left, which explains nothing
        return False
    count = EFFECTIVE * float(fit.pairs.sum())
    more = np.count_nonzero(fit.check.values) - np.count_nonzero(than.check.values)
    gain = 2 * count * np.log(misfit(than) / misfit(fit)) - _surprise(fit) + _surprise(than)
    return bool(misfit(fit) < WORTH * misfit(than) and gain > more * np.log(count))


def _surprise(fit: Loop) -> float:
    """By how much the errors are larger than what was known of them before, as part of chi2."""
    return float(np.sum((fit.check.values / fit.check.prior) ** 2))
