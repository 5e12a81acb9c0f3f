"""Frame to model: where was the camera for each frame, given what the model looks like from any pose?

The model is a function of a pose, so this file knows no volume. A frame that cannot be placed is a value with a
reason, not an end: the next one is tried from the last good pose with a wider reach, then from older poses.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain

import numpy as np

from fusion.geometry.depth import PointMap
from fusion.geometry.pose import Array, angle, inverse, pose
from fusion.tracking.equations import PairLimits, Points, equations, lay_out, thinned
from fusion.tracking.icp import IcpResult, IcpSettings, align_points

Model = Callable[[Array], PointMap]  # T_world_camera (4, 4) -> what the model shows a camera there
Sure = Callable[["Tracked"], bool]  # whether a frame is really where its surface fits
Places = Callable[[], Iterable[Array]]  # T_world_camera (4, 4) of where a lost frame may be, the likeliest first

UNSURE = "the surface fits here, but that it is the same place is not sure"
FEWEST = 300  # pixels with a normal that a frame needs: a 20 x 15 image of surface (guess)
# after a loss the pose may be further off than between neighbours: wider reaches, more steps to walk them
WIDE = IcpSettings(reaches=(0.30, 0.10, 0.03), iterations=(30, 15, 6), min_inlier_share=0.5)


@dataclass(frozen=True)
class TrackerSettings:
    """How frames are placed."""

    icp: IcpSettings = field(default_factory=IcpSettings)  # between neighbouring frames
    wide: IcpSettings = WIDE  # after a lost frame
    past_poses: int = 6  # how many older poses to try when the last good one does not help
    # max_shift, max_turn: largest motion between two frames in a row [m], [rad]; more is taken for a failure
    max_shift: float = 0.30
    max_turn: float = 0.52


@dataclass(frozen=True)
class Tracked:
    """Where a frame was placed, and the evidence for it."""

    T_world_camera: Array  # (4, 4), all NaN when the frame is rejected
    status: str = "ok"  # "ok", or a sentence saying why the frame is rejected
    # inlier_share, residual, information, unconstrained: as in `IcpResult`
    inlier_share: float = float("nan")
    residual: float = float("nan")
    information: Array = field(default_factory=lambda: np.zeros((6, 6)))
    unconstrained: tuple[str, ...] = ()
    tried: bool = True  # the frame shows a surface, so that it could be placed

    @property
    def ok(self) -> bool:
        """True when the frame has a pose."""
        return self.status == "ok"


class Tracker:
    """Follows a camera; state: the good poses so far, and how many frames have been lost since."""

    def __init__(self, model: Model, settings: TrackerSettings | None = None, start: Array | None = None) -> None:
        self.model = model
        self.start = np.eye(4) if start is None else start  # T_world_camera of the first frame
        self.settings = settings or TrackerSettings()
        self.past: list[tuple[int, Array]] = []  # (frame, T_world_camera) of the good ones
        self.lost = 0
        self.count = 0
        self._shown: tuple[Array, PointMap] | None = None  # from where the model was looked at last, and what it showed

    def skip(self, reason: str) -> Tracked:
        """Count a frame that cannot be looked at as lost."""
        return self._reject(reason)

    def place(self, frame: PointMap, sure: Sure | None = None, same: bool = False, places: Places = tuple) -> Tracked:
        """Place the next frame; the first that shows a surface is where the start says.

        Args:
            frame: its surface.
            sure: asked of a pose that was found again after a loss; where it says no, the next is tried.
            places: asked where the last poses do not help.
            same: the model is as it was for the last frame, which stood near: what it looked like there will do.
        """
        known = int(np.isfinite(frame.normals[..., 0]).sum())
        if known < FEWEST:
            return self._reject(f"only {known} pixels show a surface")
        if not self.past:
            self._accept(self.start)
            return Tracked(self.start)
        points = lay_out(frame, self.settings.icp.points[-1])
        tried = self._follow(points, same)
        if tried.ok and self.lost and sure is not None and not sure(tried):
            tried = replace(tried, status=UNSURE)
        if not tried.ok:
            tried = self._recover(points, tried, sure, places)
        if not tried.ok:
            return self._reject(tried.status, tried)
        self._accept(tried.T_world_camera)
        return tried

    def _follow(self, points: Points, same: bool) -> Tracked:
        """From the better of two guesses: the motion goes on, or the camera stands still."""
        last = self.past[-1][1]
        if self._shown is None or self.lost or not same:
            self._shown = last, self.model(last)
        at, seen = self._shown
        since = inverse(at) @ last
        guesses = [since, *(since @ motion for motion in self._velocity())]
        if len(guesses) > 1:
            some, reach = thinned(points, self.settings.icp.points[0]), max(self.settings.icp.reaches)
            guesses.sort(key=lambda guess: _misfit(some, guess, seen, reach))
        result = align_points(points, seen, guesses[0], self.settings.icp)
        return self._judge(result, at)

    def _velocity(self) -> list[Array]:
        """The last motion, when the last two frames were both placed."""
        if len(self.past) < 2 or self.lost or self.past[-1][0] - self.past[-2][0] != 1:
            return []
        return [inverse(self.past[-2][1]) @ self.past[-1][1]]

    def _recover(self, points: Points, first: Tracked, sure: Sure | None, places: Places) -> Tracked:
        """With a wider reach from the last good pose, after a loss also from older ones; then from other places."""
        poses = [self.past[-1][1]]
        if self.lost:
            poses += _spread([T for _, T in self.past[:-1]], self.settings.past_poses)
        best = first
        for T in chain(poses, places()):
            tried = self._judge(align_points(points, self.model(T), np.eye(4), self.settings.wide), T)
            if tried.ok and self.lost and sure is not None and not sure(tried):
                tried = replace(tried, status=UNSURE)
            if tried.ok:
                return tried
            if tried.inlier_share > best.inlier_share:
                best = tried
        return best

    def _judge(self, result: IcpResult, T_world_model: Array) -> Tracked:
        status = result.status
        moved = result.T_model_source
        shift, turn = float(np.linalg.norm(moved[:3, 3])), angle(moved)
        grown = 1 + self.lost
        if result.ok and (shift > self.settings.max_shift * grown or turn > self.settings.max_turn * grown):
            status = f"a jump of {shift:.2f} m and {np.degrees(turn):.0f} degrees is no motion between two frames"
        return Tracked(
            _orthonormal(T_world_model @ moved), status, result.inlier_share, result.residual, result.information,
            result.unconstrained,
        )  # fmt: skip

    def _accept(self, T_world_camera: Array) -> None:
        self.past.append((self.count, T_world_camera))
        self.count += 1
        self.lost = 0

    def _reject(self, status: str, tried: Tracked | None = None) -> Tracked:
        self.count += 1
        self.lost += 1
        nowhere = np.full((4, 4), np.nan)
        if tried is None:
            return Tracked(nowhere, status, 0.0, tried=False)
        return Tracked(nowhere, status, tried.inlier_share, tried.residual, tried.information, tried.unconstrained)


def _misfit(points: Points, T_model_source: Array, seen: PointMap, reach: float) -> float:
    """Mean squared distance over the visible points, a point without a partner counting as far off [m^2]."""
    sums = equations(points, T_model_source, seen, PairLimits(reach, 0.5, open_to=float("inf")))
    if sums.visible == 0:
        return reach**2
    return (sums.squares + (sums.visible - sums.pairs) * reach**2) / sums.visible


def _orthonormal(T: Array) -> Array:
    """The nearest rigid pose: rounding errors double with each velocity guess otherwise."""
    U, _, Vt = np.linalg.svd(T[:3, :3])
    return pose(U @ Vt, T[:3, 3])


def _spread(poses: Sequence[Array], count: int) -> list[Array]:
    """At most `count` poses, spread evenly, the newest first."""
    if not poses:
        return []
    picks = np.unique(np.linspace(0, len(poses) - 1, min(count, len(poses))).round().astype(int))
    return [poses[i] for i in picks[::-1]]
