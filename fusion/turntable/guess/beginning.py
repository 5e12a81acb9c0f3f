"""How the motion of the table begins: from what was told, or from the views alone."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.errors import TrackingError
from fusion.turntable.all_views.joint import State
from fusion.turntable.all_views.loop import LoopSettings, close_loop
from fusion.turntable.all_views.together import REACH
from fusion.turntable.axis import Axis, Turns
from fusion.turntable.guess.alone import find_alone, found_again
from fusion.turntable.guess.decided import Alone
from fusion.turntable.guess.start import axis_guesses, find_turns, search_range
from fusion.turntable.pairs.edges import CLEAR, FEWEST, ViewStack, above, stack, thinned_view
from fusion.turntable.pairs.misfit import misfits
from fusion.turntable.table.plate import ground_height
from fusion.turntable.views import ObjectView, Region

Array = NDArray[np.float64]
POINTS_FIRST = 1000  # source points per frame


@dataclass(frozen=True)
class Begun:
    """A first motion."""

    used: NDArray[np.intp]  # frames that show the object
    # seen, shown: their views, whole, and thinned above the plate
    seen: list[ObjectView]
    shown: list[ObjectView]
    floor: float  # height of the plate's end along the axis [m]
    # axis, angles: of these frames [rad]
    axis: Axis
    angles: Array
    by_hand: Alone | None = None  # where a hand turned the object about no fixed axis
    print_contradicts: bool = False  # see `Alone`


def begin(
    views: Sequence[ObjectView], region: Region, commanded: Array | None
) -> tuple[NDArray[np.intp], list[ObjectView], list[ObjectView], float, Turns]:
    """Frames that show the object, their views whole and thinned above the plate, where it ends, and a first motion."""
    begun = begun_with(views, region, commanded)
    return begun.used, begun.seen, begun.shown, begun.floor, Turns(begun.axis, begun.angles)


def begun_with(
    views: Sequence[ObjectView], region: Region, commanded: Array | None, start: State | Turns | None = None
) -> Begun:
    """The first motion: as told, checked against the views, or found from these alone.

    Args:
        views: (n) with all their surface points.
        region: where the object is.
        commanded: (n,) angles [rad] as told, or None.
        start: a motion of all views that was found before, NaN where a view had no place in it; what a hand made is
            decided anew, turns about one axis are a beginning as they are. None for nothing.

    Raises:
        TrackingError: the views do not fit any turn about one axis.
    """
    empty = np.array([len(v.points) < 100 for v in views])
    empty |= False if start is None else np.isnan(start.angles)
    used = np.flatnonzero(~empty)
    seen = [v for v, nothing in zip(views, empty, strict=True) if not nothing]
    if len(used) < 3:
        raise TrackingError("too few frames show the object", found=len(used), expected="3 or more", do="check --box")
    told = None if commanded is None else commanded[used]
    alone = None
    if isinstance(start, Turns):
        axis, angles = start.axis, start.angles[used]
    elif told is None or start is not None:
        alone = find_alone(seen, region) if start is None else found_again(seen, start.of(used))
        axis, angles = alone.state.axis, alone.state.angles
    else:
        stride, steps, axis = _first_axis(seen, (region.low + region.high) / 2, told)
    ground = ground_height(seen, axis)
    floor = -np.inf if ground is None else ground + CLEAR
    plain = [v.plain() for v in seen]
    shown = [above(v, axis, floor, POINTS_FIRST) for v in plain]
    if np.median([len(v.points) for v in shown]) < FEWEST:
        shown, floor = [thinned_view(v, POINTS_FIRST) for v in plain], -np.inf
    if start is None and told is not None:
        axis, angles = _chain(shown, axis, steps, stride, told)
    by_hand = None if alone is None or alone.lens is None else alone
    contradicts = alone is not None and alone.print_contradicts
    return Begun(used, seen, shown, floor, axis, angles - angles[0], by_hand, contradicts)


def _first_axis(views: list[ObjectView], centre: Array, commanded: Array | None) -> tuple[int, Array, Axis]:
    """Stride [frames] whose turns are large enough to see, the turns of some pairs so far apart, and the axis."""
    stride = 1
    if commanded is not None:
        known = np.abs(np.diff(commanded))
        step = float(np.median(known[known > 1e-4])) if (known > 1e-4).any() else np.deg2rad(5)
        stride = int(np.clip(round(np.deg2rad(15) / step), 1, max(1, (len(views) - 1) // 2)))
    while True:
        starts = np.arange(0, len(views) - stride, max(1, (len(views) - stride) // 8)).tolist()
        both = stack([thinned_view(views[k].plain(), POINTS_FIRST) for i in starts for k in (i, i + stride)])
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


def _try_axis(both: ViewStack, axis: Axis) -> tuple[float, Axis, Array]:
    """Misfit, axis and turns of pairs of frames that stand one after the other, starting from one guess of the axis."""
    n = len(both.views)
    alone = [(k, k + 1) for k in range(0, n, 2)]
    turns = np.zeros(len(alone))
    for _ in range(2):
        angles = np.zeros(n)
        angles[1::2] = find_turns(both, alone, axis, np.tile(search_range(), (len(alone), 1)), REACH).turns
        fit = close_loop(both, Turns(axis, angles), alone, LoopSettings((REACH, REACH / 2), (6, 4)))
        axis, turns = fit.axis, fit.angles[1::2] - fit.angles[0::2]
    if axis.direction[1] > 0:  # up is -y
        return 1.0, axis, turns
    return float(np.mean(misfits(both, alone, Turns(axis, turns), 0.02))), axis, turns


def _chain(views: list[ObjectView], axis: Axis, turns: Array, stride: int, commanded: Array | None) -> Turns:
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
        steps = np.where(found.misfit > 0.7 * misfits(seen, alone, Turns(axis, expected), REACH), expected, steps)
    at_keys = np.concatenate([[0.0], np.cumsum(steps)])
    fit = close_loop(seen, Turns(axis, at_keys), alone, LoopSettings((REACH, REACH / 2), (5, 3)))
    if commanded is not None:  # between the keys as told
        told_angles = sign * (commanded - commanded[0])
        correction = np.interp(np.arange(len(views)), keys, at_keys - told_angles[keys])
        return Turns(fit.axis, told_angles + correction)
    return Turns(fit.axis, np.interp(np.arange(len(views)), keys, fit.angles))
