"""What a turning object says of the focal length, without the rest of the motion."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.turntable.all_views.camera_fit import SYSTEMATIC, fit_camera
from fusion.turntable.all_views.together import together
from fusion.turntable.axis import Turns
from fusion.turntable.guess.beginning import begin
from fusion.turntable.motion import Motion
from fusion.turntable.pairs.edges import stack
from fusion.turntable.selfcheck import no_errors
from fusion.turntable.views import ObjectView, Region

Array = NDArray[np.float64]

RIM_PX = 0.5  # by which a rim may stand beside itself: half of the pixel that mixes what is before and behind


@dataclass(frozen=True)
class FocalCheck:
    """What a turning object says of the focal length."""

    relative: float  # error of the stated one, f_right / f_stated - 1
    std: float  # its standard deviation from the fit
    turned: float  # range of the angles [rad]
    frames: int  # that show the object
    rims: float = 0.0  # relative change of what a scan asks for by rims that stand `RIM_PX` beside themselves

    @property
    def told(self) -> float:
        """How well the scan tells it: what the fit knows, and what it does not, where the rims are."""
        return float(np.hypot(self.std, self.rims))

    def deviations(self, camera: Camera) -> float:
        """How far the stated focal length is off, in standard deviations of this check and of the camera's own."""
        own = camera.std.get("fx", 0.0) / camera.fx
        return abs(self.relative) / float(np.linalg.norm([self.std, SYSTEMATIC, own]))

    def withdrawn(self) -> "FocalCheck":
        """As good as nothing: the scan fits no better with the focal length that it asked for."""
        return replace(self, std=max(self.std, abs(self.relative)))

    def said(self) -> str:
        """ "+9.0 +- 0.8 %"."""
        return f"{self.relative * 100:+.1f} +- {self.std * 100:.1f} %"


def focal_of(motion: Motion, camera: Camera) -> FocalCheck:
    """What the fit of a whole scan says of the focal length of the camera that saw it."""
    known = motion.angles[np.isfinite(motion.angles)]
    relative = float(np.expm1(motion.focal_check.values[0]))
    rims = RIM_PX * float(motion.axis.point[2]) / (camera.fx * motion.radius)
    return FocalCheck(relative, motion.focal_std, float(np.ptp(known)), len(known), rims)


def check_focal(views: Sequence[ObjectView], region: Region, commanded: Array | None = None) -> FocalCheck:
    """The beginning of `estimate_motion`, as far as the focal length: a few times as quick.

    Args:
        views, region, commanded: as in `estimate_motion`.

    Raises:
        TrackingError: the views do not fit any turn about one axis.
    """
    used, _, shown, _, (axis, angles) = begin(views, region, commanded)
    seen = stack(shown)
    middle, edges = together(
        seen, Turns(axis, angles), no_errors(seen.views), None if commanded is None else commanded[used]
    )
    # the shape alone: in so few frames, a log that holds the angles lets errors of depth take the focal length's part
    fit = fit_camera(seen, middle, edges)
    turned = float(np.ptp(fit.angles))
    return FocalCheck(float(np.expm1(fit.check.values[0])), float(fit.check_std[0]), turned, len(used))


def typical_step(views: Sequence[ObjectView], region: Region) -> float:
    """How far the object turns from view to view [rad], roughly and without sign.

    Raises:
        TrackingError: the views do not fit any turn about one axis.
    """
    used, _, _, _, (_, angles) = begin(views, region, None)
    return float(np.ptp(angles)) / max(int(used[-1] - used[0]), 1)
