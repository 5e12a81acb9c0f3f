"""The motion of the table: from the views of a scan to one axis and one angle per frame."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.errors import TrackingError
from fusion.geometry import pose
from fusion.turntable.all_views.joint import State
from fusion.turntable.all_views.refined import refined
from fusion.turntable.axis import Axis, Turns
from fusion.turntable.guess.alone import held_through
from fusion.turntable.guess.beginning import Begun, begun_with
from fusion.turntable.guess.decided import Alone
from fusion.turntable.pairs.edges import above
from fusion.turntable.selfcheck import DepthKnown, SelfCheck, no_errors
from fusion.turntable.table.plate import find_plate
from fusion.turntable.views import ObjectView, Region

Array = NDArray[np.float64]
LEAST_TURN = np.deg2rad(5)  # less is no scan of an object from its sides
POINTS_FINE = 3000  # source points per frame
MISPLACED = 0.5  # misfit of a frame with its partners from which it is left out (guess)
POINTS_OUTLINE = 200_000  # that tell how far the object reaches


@dataclass(frozen=True)
class Motion:
    """What the joint fit found."""

    axis: Axis  # in the camera's frame, its point at the plate's height where a plate was seen
    angles: Array  # (n,) turn of each frame [rad], 0 at the first; NaN for rejected frames
    angle_std: Array  # (n,) [rad]
    residual: Array  # (n,) [m]; support: (n,) share of the visible points that fit
    support: Array
    rejected: dict[int, str]  # frame to reason
    # height of the plate above the axis' point [m], None when no plate was seen; `table`: that of the table below a
    # plate that is not round, else None
    plate: float | None
    # radius, bottom, top: cylinder that holds what turns, heights from the axis' point [m]
    radius: float
    bottom: float
    top: float
    camera_check: SelfCheck  # what camera and depth seem to get wrong, with all errors fitted
    taken_out: SelfCheck  # errors of depth without which the motion was found, as the model of it has to be made
    focal_check: SelfCheck  # the same with the camera alone (focal length and principal point) fitted
    focal_std: float  # standard deviation of the relative focal length in `focal_check`
    # (n, 2) of the object along `axis.across()`, after the turn [m], where a hand turned it about no fixed axis; None
    # where the axis holds
    shifts: Array | None = None
    spread: float = 0.0  # rms distance of overlapping views from each other [m], where that was measured
    held: bool = False  # the angles are held by print, or by a hand: shape alone would only make them worse
    print_contradicts: bool = False  # print says that the object moves as its shape does not, and was left out
    marked: int = 0  # frames of which marks on what the object stands on tell the turn
    table: float | None = None
    plate_thickness: float = 0.0  # how thick a plate that is not round may be at most, in widths
    # (4,) of the axis, tilts [rad] and shifts [m] of the camera along x and y of the object's frame; None where no
    # model of all frames was fitted
    axis_std: Array | None = None
    # relative, of the size by what may be wrong with the depth, see `model/size`; None where no calibration says how
    # wrong it may be
    size_std: float | None = None

    @property
    def size(self) -> float:
        """Radius or half the height of what turns [m], whichever is more."""
        return max(self.radius, (self.top - self.bottom) / 2)

    @property
    def beginning(self) -> State | Turns:
        """As another fit begins from it: what print or a hand holds is decided anew."""
        if not self.held:
            return Turns(self.axis, self.angles)
        return State(self.axis, self.angles, np.zeros((len(self.angles), 2)) if self.shifts is None else self.shifts)


def estimate_motion(
    views: Sequence[ObjectView],
    region: Region,
    commanded: Array | None = None,
    known: DepthKnown | None = None,
    start: Motion | None = None,
) -> Motion:
    """Find axis and angles.

    Args:
        views: (n) with all their surface points (they are thinned here); empty ones are rejected.
        region: where the object is.
        commanded: (n,) angles [rad] that the table was told or said, of unknown sign; None when nothing is known.
        known: how well a calibrated depth is known; None for a depth as the camera gives it.
        start: what was found before some pixels were left out, or by another camera; its rejected frames stay so.

    Raises:
        TrackingError: the views do not fit any turn about one axis.
    """
    n = len(views)
    begun = begun_with(views, region, commanded, None if start is None else start.beginning)
    used, seen, shown, floor, axis, angles = begun.used, begun.seen, begun.shown, begun.floor, begun.axis, begun.angles
    centre = (region.low + region.high) / 2
    if begun.by_hand is not None:
        return by_hand(begun.by_hand, begun, n, centre)
    told = None if commanded is None else commanded[used]
    fine = lambda: [above(v.plain(), axis, floor, POINTS_FINE) for v in seen]  # noqa: E731
    fit, camera_fit, taken_out = refined(shown, fine, Turns(axis, angles), told, known)
    held = None if told is None else held_through(seen, Turns(fit.axis, fit.angles))
    if held is not None:
        return by_hand(held, begun, n, centre)
    rejected = {int(i): "the object is not visible" for i in np.setdiff1d(np.arange(n), used)}
    bad = fit.support < 0.5 * np.median(fit.support)
    rejected |= {int(used[k]): f"only {fit.support[k]:.0%} of the visible surface fits" for k in np.flatnonzero(bad)}

    def whole(values: Array) -> Array:
        out = np.full(n, np.nan)
        out[used] = values
        return out

    angles = whole(np.where(bad, np.nan, fit.angles))
    angles -= angles[np.isfinite(angles)][0]
    _refuse_still(angles)
    final = fit.axis.nearest_to(centre)
    seen = [taken_out.view(v) for v in seen] if taken_out.wrong_depth else seen
    plate = find_plate(seen, final, final.turns(fit.angles))
    final = final if plate is None else final.raised(plate.height)
    some = max(1, sum(len(v.points) for v in seen) // POINTS_OUTLINE)
    reach, above_point = final.distance(np.concatenate([v.points[::some] for v in seen]).astype(float))
    return Motion(
        axis=final,
        angles=angles,
        angle_std=whole(fit.angle_std),
        residual=whole(fit.residual),
        support=whole(fit.support),
        rejected=rejected,
        plate=None if plate is None else 0.0,
        table=None if plate is None or plate.table is None else plate.table - plate.height,
        plate_thickness=0.0 if plate is None else plate.thickness,
        radius=float(np.percentile(reach, 99.8)),
        bottom=float(np.percentile(above_point, 0.2)),
        top=float(np.percentile(above_point, 99.8)),
        camera_check=fit.check,
        taken_out=taken_out,
        focal_check=camera_fit.check,
        focal_std=float(camera_fit.check_std[0]),
        print_contradicts=begun.print_contradicts,
    )


def by_hand(found: Alone, begun: Begun, n: int, centre: Array) -> Motion:
    """The motion of an object that a hand turned and moved, or of which only print tells how far it turned.

    Args:
        found: of the views that show the object.
        begun: which views these are.
        n: number of frames.
        centre: (3,) of the region [m].
    """
    used, seen = begun.used, begun.seen
    state, lens = found.state, found.lens
    assert lens is not None
    axis = state.axis.nearest_to(centre)
    plate = find_plate(seen, axis, state.motions())
    axis = axis if plate is None else axis.raised(plate.height)
    back = pose.inverse(state.motions())
    some = max(1, sum(len(v.points) for v in seen) // POINTS_OUTLINE)
    points = np.concatenate(
        [pose.transform(T, v.points[::some].astype(float)) for T, v in zip(back, seen, strict=True)]
    )
    reach, above_point = axis.distance(points)
    # views far apart overlap little: where the ground tells their places, that speaks against none
    bad = found.joint.misfit > MISPLACED
    marked = sorted({view for edge in found.told.edges for view in edge})
    bad[marked] = False

    def whole(values: Array) -> Array:
        out = np.full((n, *values.shape[1:]), np.nan)
        out[used] = values
        return out

    angles = whole(np.where(bad, np.nan, state.angles))
    _refuse_still(angles)
    sigma = np.array([float(np.median(v.sigma)) for v in seen])
    stated = no_errors(seen)
    values = stated.values.copy()
    values[0] = lens.state.focal
    return Motion(
        axis=axis,
        angles=angles - angles[np.isfinite(angles)][0],
        angle_std=whole(found.joint.angle_std),
        residual=whole(found.joint.scale * sigma),
        support=whole(1 - found.joint.misfit),
        rejected={int(i): "the object is not visible" for i in np.setdiff1d(np.arange(n), used)}
        | {int(used[k]): f"only {1 - found.joint.misfit[k]:.0%} of the surface fits" for k in np.flatnonzero(bad)},
        plate=None if plate is None else 0.0,
        table=None if plate is None or plate.table is None else plate.table - plate.height,
        plate_thickness=0.0 if plate is None else plate.thickness,
        radius=float(np.percentile(reach, 99.8)),
        bottom=float(np.percentile(above_point, 0.2)),
        top=float(np.percentile(above_point, 99.8)),
        camera_check=stated,
        taken_out=stated.open_for(()),
        focal_check=replace(stated, values=values),
        focal_std=lens.focal_std,
        shifts=whole(state.shifts) if found.wanders else None,
        held=True,
        marked=len(marked),
        spread=found.joint.spread,
    )


def _refuse_still(angles: Array) -> None:
    known = angles[np.isfinite(angles)]
    turned = float(np.ptp(known)) if len(known) else 0.0
    if turned < LEAST_TURN:
        raise TrackingError(
            "the object hardly turns",
            found=f"{np.rad2deg(turned):.1f} deg in {len(known)} frames",
            expected=f"{np.rad2deg(LEAST_TURN):.0f} deg or more",
            do="use `fusion reconstruct` if the camera moved",
        )
