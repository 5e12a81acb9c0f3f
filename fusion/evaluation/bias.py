"""How far the mean depth is from what should be seen: on the axis, and over the image."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.shared_noise import centre_of
from fusion.evaluation.still.statistics import Still
from fusion.evaluation.surface import WALL, ExpectedSurface
from fusion.geometry.camera import Camera
from fusion.geometry.robust import robust_std
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View

# robust standard deviations of the rest, and metres: what hangs on a wall, not what a lens or the wall bends (guesses)
PROUD, PROUD_M = 6.0, 0.005
LEVEL = 1.645  # standard deviations of a 90 % interval
INDEPENDENT = 16.0  # [px^2] that share their error: lens and filters correlate neighbours (guess)

Image = NDArray[np.floating]


@dataclass(frozen=True)
class Bias:
    """Errors of the mean depth of a stretch."""

    distance: float  # of the surface at the image's centre [m]
    truth: str  # "distance_m", "scene" or "": then only the residual from the plane is known
    offset: float  # mean depth of the centre less the truth [m], NaN without one
    offset_std: float  # how well it is known, the stated distance's own deviation included [m]
    corrected: float  # the same after the sensor model has undone what it can [m], NaN without a model
    spread: float  # standard deviation of one depth in the centre, pixels and frames together [m]
    residual: Image  # (h, w) mean depth less plane or scene [m], NaN beside it
    rms: float  # of the residual [m], its own noise not taken out
    # how far behind the surface's plane the middle stands [m] where that is far more than the rest is off it, else 0
    proud: float = 0.0

    @property
    def beside(self) -> bool:
        """Whether the middle is another thing than the surface: nothing is told of it."""
        return bool(self.proud) and not np.isfinite(self.spread)

    def stands(self) -> str:
        """Where the middle stands, in words."""
        side = "behind" if self.proud > 0 else "before"
        return f"the image's middle stands {abs(self.proud) * 1e3:.1f} mm {side} the plane of the rest"


def bias_of(
    still: Still, usual: Image, surface: ExpectedSurface, camera: Camera, sensor: Sensor | None, distance_std: float
) -> Bias | None:
    """Bias of a stretch; None where nothing is known of the surface.

    Args:
        usual: (h, w) depth that frames usually show [m], whatever is there.
        distance_std: standard deviation of a stated distance [m].
    """
    if surface.kind == "unknown":
        return None
    mean = still.depth.mean
    with np.errstate(invalid="ignore"):
        # a plane goes on beyond the region that is counted
        residual = mean - surface.depth
        residual[~(np.abs(residual) <= WALL * surface.depth)] = np.nan
    patch = centre_of(camera.shape)
    # a skewed noise shifts the mean against the plane through the usual depths
    shift_of_mean = _finite_median(residual[surface.region]) if surface.kind == "plane" else 0.0
    shape = residual - shift_of_mean
    rest, known_here = residual[patch], np.isfinite(residual[patch])
    count = int(known_here.sum())
    middle = float(np.median(rest[known_here])) if count else float("nan")
    shift, truth = _shift(surface)
    around = robust_std(shape[surface.region & np.isfinite(shape)]) if surface.kind == "plane" else np.inf
    proud = middle - shift_of_mean
    stands_out = abs(proud) > max(PROUD * around, PROUD_M)
    spread = float(np.hypot(_rms(still.depth.std[patch]), float(rest[known_here].std()) if count else 0.0))
    own = spread / np.sqrt(max(count / INDEPENDENT, 1.0))
    stated = distance_std if truth == "distance_m" else 0.0
    return Bias(
        distance=surface.distance,
        truth=truth,
        offset=middle + shift if truth else float("nan"),
        offset_std=float(np.hypot(own, stated)) if truth and count else float("nan"),
        corrected=middle + shift + _correction(still, surface, camera, sensor) if truth else float("nan"),
        spread=spread,
        residual=shape,
        rms=_rms(shape),
        proud=_beside(usual[patch] - surface.depth[patch], surface) if not count else proud if stands_out else 0.0,
    )


def _beside(off: Image, surface: ExpectedSurface) -> float:
    """How far behind its plane the middle is [m], of which no value is one of the plane; 0 where it has no depth."""
    seen = np.isfinite(off)
    return float(np.median(off[seen])) if surface.kind == "plane" and 2 * seen.sum() > seen.size else 0.0


def _shift(surface: ExpectedSurface) -> tuple[float, str]:
    """What to add to the residual from the surface to get the error, and where the truth comes from."""
    if surface.kind == "scene":
        return 0.0, "scene"
    if not np.isfinite(surface.stated):
        return 0.0, ""
    if surface.kind == "distance":
        return 0.0, "distance_m"
    # the fitted plane moved to the stated distance keeps its tilt
    return surface.plane_distance - surface.stated, "distance_m"


def _correction(still: Still, surface: ExpectedSurface, camera: Camera, sensor: Sensor | None) -> float:
    """Median change of the centre's mean depth when the model undoes what it knows [m]; NaN without a model."""
    if sensor is None:
        return float("nan")
    mean = still.depth.mean
    ir = None if still.ir is None else np.nan_to_num(still.ir.mean)
    view = View(camera, mean, surface.incidence, ir=ir)
    patch = centre_of(camera.shape)
    return _finite_median((sensor.correct(mean, view) - mean)[patch])


def _finite_median(values: Image) -> float:
    values = values[np.isfinite(values)]
    return float(np.median(values)) if values.size else float("nan")


def _rms(values: Image) -> float:
    values = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(values**2))) if values.size else float("nan")
