"""The turns of all views together, then errors of camera and depth, and the axis as stated."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Principle
from fusion.turntable.all_views.camera_fit import DEPTH_ERRORS, WORTH, believed, contradicts, fit_camera, misfit
from fusion.turntable.all_views.log import of_its_sign
from fusion.turntable.all_views.loop import COARSE_POINTS, Loop, LoopSettings, choose_edges, close_loop
from fusion.turntable.all_views.together import LEFT_OPEN, TILTS, WIDEST, together
from fusion.turntable.axis import Turns
from fusion.turntable.pairs.edges import stack
from fusion.turntable.selfcheck import DepthKnown, SelfCheck, no_errors
from fusion.turntable.views import ObjectView

Array = NDArray[np.float64]


def refined(
    views: list[ObjectView],
    finer: Callable[[], list[ObjectView]],
    guess: Turns,
    commanded: Array | None,
    known: DepthKnown | None,
) -> tuple[Loop, Loop, SelfCheck]:
    """The turns together, then errors of camera and depth as far as no calibration tells them; last the axis as stated.

    Returns:
        The motion for the stated camera, the fit in which the camera alone was free, and the errors of depth that are
        taken out of the views, with what may still be found of them.
    """
    seen = stack(views)
    stated = no_errors(seen.views, known)
    middle, edges = together(seen, guess, stated, commanded)
    told = None if commanded is None else of_its_sign(middle.angles, commanded)
    flight = known is not None and seen.views[0].map.camera.principle == Principle.TIME_OF_FLIGHT
    # pairs of views tell the tilts only; of what else is left their own errors are as large, and the model tells it
    first, last = (TILTS, LEFT_OPEN) if flight else ((), ())
    camera_fit = fit_camera(seen, middle, edges, told, last)
    some = seen.thinned(COARSE_POINTS)  # which one is right shows in some of the points

    def fitted(free: tuple[str, ...], check: SelfCheck | None) -> Loop:
        passes = LoopSettings((0.01, 0.008), (4, 3), free_camera=free, told=told)
        return close_loop(some, Turns(middle.axis, middle.angles), edges, passes, check)

    plain = fitted(first, stated)
    lens = () if "fx" in seen.views[0].map.camera.std else ((*first, "focal"),)
    ways = (*lens, DEPTH_ERRORS) if known is None else lens
    chosen, best, begin = first, plain, middle.check
    for free in ways:  # errors of camera or depth must earn their place: they cost precision
        fit = fitted(free, begin)
        if "focal" in free and not (contradicts(fit) and contradicts(camera_fit)):
            begin = begin.depth_alone()
        elif believed(fit, best):
            chosen, best = free, fit
    if best is plain:
        return plain, camera_fit, plain.check.open_for(last)
    passes = LoopSettings((0.01, 0.006), (5, 5), free_camera=chosen, told=told)
    seen = stack(finer())
    fine = close_loop(seen, Turns(best.axis, best.angles), choose_edges(best.angles, WIDEST, 10), passes, best.check)
    if WORTH * misfit(fine) > misfit(best):  # more points fit worse: the errors ran away with noise
        return plain, camera_fit, plain.check.open_for(last)
    # the volume is filled through the camera as it is stated: the axis must stand where that sees it
    passes = LoopSettings((0.015, 0.01), (2, 3), free_angles=False)
    taken_out = fine.check.depth_alone() if flight else stated
    fit = close_loop(seen, Turns(fine.axis, fine.angles), edges, passes, taken_out)
    fit = replace(fit, angles=fine.angles, angle_std=fine.angle_std, check=fine.check)
    return fit, camera_fit, taken_out.open_for(last)
