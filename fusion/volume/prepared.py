"""A corrected frame made ready for tracking and fusion, and its fusion."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.depth import PointMap, point_map
from fusion.geometry.pose import Array
from fusion.progress import each
from fusion.recording.recording import Frame
from fusion.sensor.moment import Moment
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View
from fusion.sensor.weights.rating import sigma_by_incidence, weight_of
from fusion.volume.settings import VolumeSettings
from fusion.volume.volume import Volume

NOISIEST = 0.5  # standard deviations above this share of the truncation would tear the surface they are fused into


@dataclass(frozen=True)
class Prepared:
    """A corrected frame ready for tracking and fusion: depth [m], its surface, and the weight of each pixel.

    `color` (h, w, 3) of the same pixels helps tracking, where it is kept; what `frame` has is fused. `passing` (h, w)
    was taken out as something that passes before the object; None where nothing was.
    """

    depth: NDArray[np.float32]
    surface: PointMap
    weight: NDArray[np.float32]
    frame: Frame
    color: NDArray[np.uint8] | None = None
    passing: NDArray[np.bool_] | None = None

    def masked(self, mask: NDArray[np.bool_]) -> "Prepared":
        """With depth and normals within a mask (h, w) alone; the points, which say what is not there, stay."""
        normals = np.where(mask[..., None], self.surface.normals, np.float32(np.nan))
        depth = np.where(mask, self.depth, np.float32(np.nan))
        return replace(self, depth=depth, surface=replace(self.surface, normals=normals))


def prepare(
    frame: Frame, camera: Camera, sensor: Sensor, moment: Moment | None = None, max_depth: float | None = None
) -> Prepared:
    """The surface of a corrected frame, and how good each pixel is."""
    depth = frame.depth.astype(np.float32)
    if max_depth is not None:
        depth[depth > max_depth] = np.nan
    view = View(camera, depth, ir=frame.ir, moment=moment or Moment(), noisier=frame.noisier)
    sigma = sigma_by_incidence(sensor, view)
    surface = point_map(depth, camera, sigma(None))
    tilted = replace(view, incidence=surface.incidence)
    return Prepared(depth, surface, weight_of(sensor, tilted, sigma(surface.incidence)), frame)


def fuse(volume: Volume, frame: Prepared, T_world_camera: Array) -> None:
    """Integrate a frame; pixels whose noise does not fit into the truncation are left out."""
    weight = fusing_weight(frame, volume.settings.truncation)
    volume.integrate(frame.depth, frame.surface.camera, T_world_camera, weight, frame.frame.color)


def fusing_weight(frame: Prepared, truncation: float) -> NDArray[np.float32]:
    """How much each pixel (h, w) counts in a volume, 0 where its noise does not fit into the truncation [m]."""
    # weights count in pixels as good as the noise limit, so their size does not depend on the sensor
    return np.asarray(frame.weight * np.float32((NOISIEST * truncation) ** 2) * fusible(frame, truncation))


def fusible(frame: Prepared, truncation: float) -> NDArray[np.bool_]:
    """Pixels (h, w) whose noise fits into the truncation [m]."""
    return np.asarray(frame.surface.sigma < NOISIEST * truncation)


def fused(
    settings: VolumeSettings, frames: Sequence[Prepared | None], poses: Array, stage: str = "integrating"
) -> Volume:
    """A volume of all frames that have a pose (n, 4, 4), NaN where there is none; `stage` names the work."""
    volume = Volume(settings)
    for frame, T in zip(each(frames, stage), poses, strict=True):
        if frame is not None and np.isfinite(T).all():
            fuse(volume, frame, T)
    return volume
