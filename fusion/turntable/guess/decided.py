"""The joint fit of all views, of one axis where that does, else of an object that a hand moved."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.errors import TrackingError
from fusion.geometry.robust import DOUBT
from fusion.turntable.all_views.camera_fit import rests_on_rims
from fusion.turntable.all_views.joint import FIXED, NOTHING, Free, Joint, PairMotions, State, angle_stds, fit_jointly
from fusion.turntable.pairs.edges import Edges, ViewStack
from fusion.turntable.pairs.pairwise import ViewPairLimits

Array = NDArray[np.float64]

POINTS_JOINT = 2000
PARTNERS = 8  # of a view in the joint fit
# what free shifts explain of gaps between views over noise, see `explained`: 1.6 to 2.5 on tables, 14 and more where a
# hand moved the object by 2 mm (tools/sets/hard_scans, seeds 404 and 405; both real recordings)
WANDERS = 5.0
# of the same by shape alone, below which nothing but print says that the object moved: what noise makes. Whatever moves
# an object across its axis moves its shape; colours of another moment than the depth do not
STAYS = 1.0
SLIPS = 2.0  # standard deviations of the angles by shape alone over those with print: shape lets them slip (guess)
TO_ITS_END = 30  # steps at most; 20 were enough for a cylinder
HOPELESS = 0.5  # misfit of views that do not turn about any axis (guess)
# reaches of pairs in metres: a camera's bent depth lays surfaces so far apart, whatever the object's size (guess)
JOINT = (ViewPairLimits(0.01, 2.0, 0.12, 1000), ViewPairLimits(0.006, 2.0, 0.12, POINTS_JOINT))
COARSE = (ViewPairLimits(0.02, 0.0, 0.24, 600), *JOINT)


@dataclass(frozen=True)
class Alone:
    """A motion found without any hint.

    Attributes:
        state: axis, angles and shifts.
        joint: the fit behind it.
        lens: the fit with focal length and shifts free where a hand turned the object about no fixed axis, or where
            print holds what shape lets slip; None where shape and one axis do.
        wanders: a hand moved the object; explained: what speaks for that, see the function.
        told: what else than the object says where it is.
        print_contradicts: print says that the object moves as its shape does not, and was left out.
    """

    state: State
    joint: Joint
    lens: Joint | None
    wanders: bool = False
    explained: float = 0.0
    told: PairMotions = NOTHING
    print_contradicts: bool = False


def best_partners(edges: Edges, worth: Array, n: int) -> Edges:
    """Both ways, each view with its best partners."""
    kept: set[tuple[int, int]] = set()
    order = np.argsort(-worth, kind="stable")
    count = np.zeros(n, int)
    for k in order:
        i, j = edges[k]
        if count[i] < PARTNERS or count[j] < PARTNERS or abs(i - j) == 1:
            kept |= {(i, j), (j, i)}
            count[[i, j]] += 1
    return sorted(kept)


def decided(seen: ViewStack, state: State, edges: Edges, told: PairMotions = NOTHING) -> Alone:
    """The joint fit, of one axis where that does; `told` is known of pairs beside what they show of the object."""
    narrow, wide = _of_one_axis_and_any(seen, state, edges, told)
    misfit = float(np.median(wide.at.misfit))
    if misfit > HOPELESS:
        raise nothing_turns(misfit)
    moved = explained(narrow, wide)
    wanders = moved >= WANDERS
    if wanders and len(seen.tones):
        by_shape, any_ = _of_one_axis_and_any(seen.plain(), state, edges, told)
        if (by_itself := explained(by_shape, any_)) < STAYS:
            return Alone(by_shape.state, by_shape, None, explained=by_itself, print_contradicts=True)
    if wanders:  # of round things shifts and axis slide along each other: a few steps leave a cylinder a cone of 0.5 mm
        wide = fit_jointly(seen, wide.state, edges, JOINT[-1:], Free(1.0), TO_ITS_END, told)
        return Alone(wide.state, wide, _of_any_lens(seen, wide.state, edges, told), True, moved, told)
    if not held_by_print(seen, narrow.state, edges, told):
        return Alone(narrow.state, narrow, None, explained=moved)
    return replace(printed(seen, (narrow.state, wide.state), edges, told), explained=moved)


def _of_one_axis_and_any(seen: ViewStack, state: State, edges: Edges, told: PairMotions) -> tuple[Joint, Joint]:
    """The joint fits of one axis, and of shifts as each view asks for them."""
    wide = fit_jointly(seen, state, edges, JOINT, Free(1.0), told=told)
    start = replace(wide.state, shifts=np.zeros_like(wide.state.shifts))
    return fit_jointly(seen, start, edges, COARSE, Free(FIXED, focal=True), told=told), wide


def printed(seen: ViewStack, near: tuple[State, State], edges: Edges, told: PairMotions = NOTHING) -> Alone:
    """The fit about one axis, by the stated camera, of what print holds; `near`: before, and where shifts are free.

    Shape may have laid the axis anywhere through the middle of a ball: print brings it back from 20 degrees.
    """
    stated = fit_jointly(seen, replace(near[0], focal=0.0), edges, COARSE, Free(FIXED), TO_ITS_END, told)
    return Alone(stated.state, stated, _of_any_lens(seen, near[1], edges, told), told=told)


def _of_any_lens(seen: ViewStack, state: State, edges: Edges, told: PairMotions) -> Joint:
    # a hand does not move the object so that a wrong focal length keeps it in shape; an axis held still, though it
    # drifts by 0.8 mm (rms), pulls the focal length by 2.2 %
    passes, free = (JOINT[0], *JOINT), Free(1.0, focal=True)
    found = fit_jointly(seen, state, edges, passes, free, told=told)
    focal = found.state.focal
    if abs(focal) < DOUBT * found.focal_std:
        return found
    clear = fit_jointly(seen.clear(), state, edges, passes, free, told=told)
    if not rests_on_rims(focal, clear.state.focal, clear.focal_std):
        return found
    return replace(found, focal_std=max(found.focal_std, abs(focal)))


def explained(narrow: Joint, wide: Joint) -> float:
    """How much more shifts of a wide fit explain of the gaps of a narrow one, of the same edges, than of noise.

    The F of nested models, about 1 where nothing was moved. The noise is that which the edges claim, or by which they
    contradict each other in the wide fit, whichever is more.
    """
    both = np.isfinite(narrow.gaps) & np.isfinite(wide.gaps)
    before, after = (fit.gaps[both].sum() / 2 for fit in (narrow, wide))  # each pair is there both ways
    n = len(wide.state.angles)
    left = 3 * both.sum() / 2 - 3 * n - 4  # freedoms: of edges, less those of views and axis
    return float((before - after) / (2 * n) / max(1.0, after / left if left > 0 else 1.0))


def held_by_print(seen: ViewStack, state: State, edges: Edges, told: PairMotions = NOTHING) -> bool:
    """Whether it is mostly print, on the object or below it, that tells the angles: without it they would be known
    clearly worse."""
    if not len(seen.tones):
        return False
    both = angle_stds(seen, state, edges, JOINT[-1], told)
    shape = angle_stds(seen, state, edges, replace(JOINT[-1], tone=0.0))
    return bool(np.median(shape[1:]) > SLIPS * np.median(both[1:]))


def nothing_turns(misfit: float) -> TrackingError:
    return TrackingError(
        "the views do not fit a turn about one axis",
        found=f"a misfit of {misfit:.2f}",
        expected=f"below {HOPELESS:g}",
        do="check that the camera stood still and that views overlap (60 degrees or less); what a hand moves freely, "
        "about no axis, is no turntable scan: `fusion reconstruct` with --box follows it",
    )
