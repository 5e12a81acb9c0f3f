"""The motion of the table: from the views of a scan to one axis and one angle per frame."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.errors import TrackingError
from fusion.turntable.axis import Axis
from fusion.turntable.edges import Stack, stack
from fusion.turntable.log import of_its_sign
from fusion.turntable.loop import COARSE_POINTS, Loop, LoopSettings, choose_edges, close_loop, no_errors
from fusion.turntable.misfit import misfits
from fusion.turntable.plate import above, ground_height, plate_height
from fusion.turntable.selfcheck import SelfCheck
from fusion.turntable.start import axis_guesses, find_turns, search_range
from fusion.turntable.together import DEPTH_ERRORS, REACH, WIDEST, WORTH, fit_camera, misfit, together
from fusion.turntable.views import Region, View

Array = NDArray[np.float64]
LEAST_TURN = np.deg2rad(5)  # less is no scan of an object from its sides
POINTS_FIRST, POINTS_FINE = 1000, 3000  # source points per frame
POINTS_OUTLINE = 200_000  # that tell how far the object reaches


@dataclass(frozen=True)
class Motion:
    """What the joint fit found.

    Attributes:
        axis: in the camera's frame, its point at the plate's height where a plate was seen.
        angles: (n,) turn of each frame [rad], 0 at the first; NaN for rejected frames.
        angle_std: (n,) [rad].
        residual: (n,) [m]; support: (n,) share of the visible points that fit.
        rejected: frame to reason.
        plate: height of the plate above the axis' point [m], None when no plate was seen.
        radius, bottom, top: cylinder that holds what turns, heights from the axis' point [m].
        camera_check: what camera and depth seem to get wrong, with all errors fitted.
        focal_check: the same with the camera alone (focal length and principal point) fitted.
        focal_std: standard deviation of the relative focal length in `focal_check`.
    """

    axis: Axis
    angles: Array
    angle_std: Array
    residual: Array
    support: Array
    rejected: dict[int, str]
    plate: float | None
    radius: float
    bottom: float
    top: float
    camera_check: SelfCheck
    focal_check: SelfCheck
    focal_std: float


def estimate_motion(
    views: Sequence[View], region: Region, commanded: Array | None = None, depth_std: float | None = None
) -> Motion:
    """Find axis and angles.

    Args:
        views: (n) with all their surface points (they are thinned here); empty ones are rejected.
        region: where the object is.
        commanded: (n,) angles [rad] that the table was told or said, of unknown sign; None when nothing is known.
        depth_std: how well a calibrated depth is known [m]; None for a depth as the camera gives it.

    Raises:
        TrackingError: the views do not fit any turn about one axis.
    """
    n = len(views)
    used, seen, shown, floor, (axis, angles) = begin(views, region, commanded)
    centre = (region.low + region.high) / 2
    told = None if commanded is None else commanded[used]
    fine = lambda: [above(v, axis, floor, POINTS_FINE) for v in seen]  # noqa: E731
    fit, camera_fit = _refine((shown, fine), (axis, angles), told, depth_std)
    rejected = {int(i): "the object is not visible" for i in np.setdiff1d(np.arange(n), used)}
    bad = fit.support < 0.5 * np.median(fit.support)
    rejected |= {int(used[k]): f"only {fit.support[k]:.0%} of the visible surface fits" for k in np.flatnonzero(bad)}

    def whole(values: Array) -> Array:
        out = np.full(n, np.nan)
        out[used] = values
        return out

    angles = whole(np.where(bad, np.nan, fit.angles))
    angles -= angles[np.isfinite(angles)][0]
    turned = float(np.ptp(angles[np.isfinite(angles)]))
    if turned < LEAST_TURN:
        raise TrackingError(
            "the object hardly turns",
            found=f"{np.rad2deg(turned):.1f} deg in {len(used)} frames",
            expected=f"{np.rad2deg(LEAST_TURN):.0f} deg or more",
            do="use `fusion reconstruct` if the camera moved",
        )
    final = fit.axis.nearest_to(centre)
    height = plate_height(seen, final)
    if height is not None:
        final = replace(final, point=final.point + height * final.direction)
    some = max(1, sum(len(v.points) for v in seen) // POINTS_OUTLINE)
    reach, above_point = final.distance(np.concatenate([v.points[::some] for v in seen]).astype(float))
    return Motion(
        axis=final,
        angles=angles,
        angle_std=whole(fit.angle_std),
        residual=whole(fit.residual),
        support=whole(fit.support),
        rejected=rejected,
        plate=None if height is None else 0.0,
        radius=float(np.percentile(reach, 99.8)),
        bottom=float(np.percentile(above_point, 0.2)),
        top=float(np.percentile(above_point, 99.8)),
        camera_check=fit.check,
        focal_check=camera_fit.check,
        focal_std=float(camera_fit.check_std[0]),
    )


def begin(
    views: Sequence[View], region: Region, commanded: Array | None
) -> tuple[NDArray[np.intp], list[View], list[View], float, tuple[Axis, Array]]:
    """Frames that show the object, their views whole and thinned above the plate, where it ends, and a first motion."""
    empty = np.array([len(v.points) < 100 for v in views])
    used = np.flatnonzero(~empty)
    seen = [v for v, nothing in zip(views, empty, strict=True) if not nothing]
    if len(used) < 3:
        raise TrackingError("too few frames show the object", found=len(used), expected="3 or more", do="check --box")
    centre = (region.low + region.high) / 2
    stride, steps, axis = _first_axis(seen, centre, None if commanded is None else commanded[used])
    ground = ground_height(seen, axis)
    floor = -np.inf if ground is None else ground + 0.008
    shown = [above(v, axis, floor, POINTS_FIRST) for v in seen]
    if np.median([len(v.points) for v in shown]) < 150:  # a flat object: keep the plate's marks and rim
        shown, floor = [_thinned(v, POINTS_FIRST) for v in seen], -np.inf
    axis, angles = _chain(shown, axis, steps, stride, None if commanded is None else commanded[used])
    return used, seen, shown, floor, (axis, angles)


def _refine(
    views: tuple[list[View], Callable[[], list[View]]],
    guess: tuple[Axis, Array],
    commanded: Array | None,
    depth_std: float | None,
) -> tuple[Loop, Loop]:
    """The turns together, then errors of camera and depth as far as no calibration tells them; last the axis as stated.

    Returns:
        The motion for the stated camera, and the fit in which the camera alone was free.
    """
    seen = stack(views[0])
    middle, edges = together(seen, *guess, commanded, depth_std)
    told = None if commanded is None else of_its_sign(middle.angles, commanded)
    camera_fit = fit_camera(seen, middle, edges, told)
    some = seen.thinned(COARSE_POINTS)  # which one is right shows in some of the points

    def fitted(free: tuple[str, ...], check: SelfCheck | None) -> Loop:
        passes = LoopSettings((0.01, 0.008), (4, 3), free_camera=free, told=told)
        return close_loop(some, (middle.axis, middle.angles), edges, passes, check)

    stated = no_errors(seen.views, depth_std)
    plain = fitted((), stated)
    lens = () if "fx" in seen.views[0].map.camera.std else (("focal",),)
    ways = (*lens, DEPTH_ERRORS) if depth_std is None else lens
    fits = [((), plain), *((free, fitted(free, middle.check)) for free in ways)]
    chosen, best = fits[0]
    for free, fit in fits[1:]:  # errors of camera or depth must earn their place: they cost precision
        if misfit(fit) < WORTH * misfit(best):
            chosen, best = free, fit
    if not chosen:
        return plain, camera_fit
    passes = LoopSettings((0.01, 0.006), (5, 5), free_camera=chosen, told=told)
    seen = stack(views[1]())
    fine = close_loop(seen, (best.axis, best.angles), choose_edges(best.angles, WIDEST, 10), passes, best.check)
    if WORTH * misfit(fine) > misfit(best):  # more points fit worse: the errors ran away with noise
        return plain, camera_fit
    # the volume is filled through the camera as it is stated: the axis must stand where that sees it
    passes = LoopSettings((0.015, 0.01), (2, 3), free_angles=False)
    fit = close_loop(seen, (fine.axis, fine.angles), edges, passes, stated)
    return replace(fit, angles=fine.angles, angle_std=fine.angle_std, check=fine.check), camera_fit


def _thinned(view: View, most: int) -> View:
    return above(view, Axis(np.zeros(3), np.array([0.0, -1.0, 0.0])), -np.inf, most)


def _first_axis(views: list[View], centre: Array, commanded: Array | None) -> tuple[int, Array, Axis]:
    """Stride [frames] whose turns are large enough to see, the turns of some pairs so far apart, and the axis."""
    stride = 1
    if commanded is not None:
        known = np.abs(np.diff(commanded))
        step = float(np.median(known[known > 1e-4])) if (known > 1e-4).any() else np.deg2rad(5)
        stride = int(np.clip(round(np.deg2rad(15) / step), 1, max(1, (len(views) - 1) // 2)))
    while True:
        starts = np.arange(0, len(views) - stride, max(1, (len(views) - stride) // 8)).tolist()
        both = stack([_thinned(views[k], POINTS_FIRST) for i in starts for k in (i, i + stride)])
        best = min((_try_axis(both, guess) for guess in axis_guesses(centre)), key=lambda found: found[0])
        typical = float(np.median(np.abs(best[2])))
        if commanded is not None or typical > np.deg2rad(7) or 2 * stride >= len(views) // 2:
            break
        stride *= 2
    if best[0] > 0.6:
        raise TrackingError(
            "the views do not fit a turn about one axis",
            found=f"a misfit of {best[0]:.2f}",
            expected="below 0.6",
            do="check that the camera stood still and steps are below 25 degrees, or give --box",
        )
    return stride, best[2], best[1].nearest_to(centre)


def _try_axis(both: Stack, axis: Axis) -> tuple[float, Axis, Array]:
    """Misfit, axis and turns of pairs of frames that stand one after the other, starting from one guess of the axis."""
    n = len(both.views)
    alone = [(k, k + 1) for k in range(0, n, 2)]
    turns = np.zeros(len(alone))
    for _ in range(2):
        angles = np.zeros(n)
        angles[1::2] = find_turns(both, alone, axis, np.tile(search_range(), (len(alone), 1)), REACH).turns
        fit = close_loop(both, (axis, angles), alone, LoopSettings((REACH, REACH / 2), (6, 4)))
        axis, turns = fit.axis, fit.angles[1::2] - fit.angles[0::2]
    if axis.direction[1] > 0:  # up is -y
        return 1.0, axis, turns
    return float(np.mean(misfits(both, alone, (axis, turns), 0.02))), axis, turns


def _chain(views: list[View], axis: Axis, turns: Array, stride: int, commanded: Array | None) -> tuple[Axis, Array]:
    """Angles (n,) of all frames, by key frames `stride` apart."""
    keys = np.append(np.arange(0, len(views) - 1, stride), len(views) - 1)
    typical = float(np.median(turns)) / stride
    sign = 1.0
    if commanded is not None:
        sign = float(np.sign(typical * np.median(np.diff(commanded)[np.diff(commanded) != 0])) or 1.0)
    expected = typical * np.diff(keys) if commanded is None else sign * np.diff(commanded[keys])
    seen, alone = stack([views[k] for k in keys]), [(k, k + 1) for k in range(len(keys) - 1)]
    found = find_turns(seen, alone, axis, expected[:, None] + np.deg2rad(np.arange(-10, 10.1, 2)), REACH)
    steps = found.turns
    if commanded is not None:  # what the table says holds unless the surface clearly contradicts
        steps = np.where(found.misfit > 0.7 * misfits(seen, alone, (axis, expected), REACH), expected, steps)
    at_keys = np.concatenate([[0.0], np.cumsum(steps)])
    fit = close_loop(seen, (axis, at_keys), alone, LoopSettings((REACH, REACH / 2), (5, 3)))
    if commanded is not None:  # between the keys as told
        told_angles = sign * (commanded - commanded[0])
        correction = np.interp(np.arange(len(views)), keys, at_keys - told_angles[keys])
        return fit.axis, told_angles + correction
    return fit.axis, np.interp(np.arange(len(views)), keys, fit.angles)
