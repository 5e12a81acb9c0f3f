"""What calibration leaves open: an error that all views share, and that no number of them takes away."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.sensor.correction.unit import depth_std
from fusion.sensor.sensor import Sensor

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Common:
    """One standard deviation of what the whole scan may be wrong by; None where nothing tells it."""

    focal: float | None  # of the focal length, relative
    depth: float | None  # of the depth at the object [m]
    distance: float  # of the object [m]
    told_by: str  # what tells the focal length: "calibration", "scan" or "nothing"
    # relative, of the size by all that may be wrong with the depth, where that is known; else the depth as a share of
    # the distance stands for it
    size: float | None = None
    blur: float = 0.0  # relative, of the size by windows and pixels that flatten what bulges

    @property
    def calibrated(self) -> bool:
        """Whether anything of it is known."""
        return len(self.unknown) < 2

    @property
    def unknown(self) -> tuple[str, ...]:
        """What nobody calibrated and nothing else tells: its part is in no number."""
        depth = self.depth is None and self.size is None
        return ("focal length",) * (self.focal is None) + ("depth",) * depth

    @property
    def scale(self) -> float:
        """Relative standard deviation of the size: a focal length too long, or a depth too large, makes it larger."""
        by_depth = (self.depth or 0.0) / max(self.distance, 1e-9) if self.size is None else self.size
        return float(np.hypot(self.focal or 0.0, by_depth))

    @property
    def whole(self) -> float:
        """Relative standard deviation of the size by all of it; what blur moves is no error of calibration."""
        return float(np.hypot(self.scale, self.blur))

    def along(self, points: Array, normals: NDArray[np.floating]) -> Array:
        """Standard deviation (n,) [m] along the normals of points (n, 3) about their middle."""
        from_middle = points - points.mean(axis=0)
        return np.asarray(self.scale * np.abs(np.einsum("ij,ij->i", from_middle, normals)))

    def values(self) -> dict[str, float | str | None]:
        """For JSON; None is what nobody knows."""
        return {
            "focal_relative": self.focal,
            "depth_m": self.depth,
            "scale_relative": self.whole if self.calibrated else None,
            "blur_relative": self.blur,
            "distance_m": self.distance,
            "focal_told_by": self.told_by,
        }


def common_errors(
    camera: Camera, sensor: Sensor | None, distance: float, seen: tuple[float, float] | None = None
) -> Common:
    """What the calibration of camera and depth says of itself.

    Args:
        camera: its `std` tells how well the focal length is known.
        sensor: as it was given; None where only a usual one is assumed.
        distance: of the object [m].
        seen: relative standard deviation of the focal length as the scan itself tells it, and what one that nobody
            calibrated may be wrong by; used where the camera states none.
    """
    depth = None if sensor is None else depth_std(sensor, camera, distance)
    if "fx" in camera.std:
        return Common(float(camera.std["fx"] / camera.fx), depth, distance, "calibration")
    if seen is None:
        return Common(None, depth, distance, "nothing")
    return Common(float(1 / np.hypot(1 / seen[0], 1 / seen[1])), depth, distance, "scan")
