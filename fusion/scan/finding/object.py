"""The object alone: the volume around it, and its mesh without plate, crumbs and small holes."""

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.scan.settings import ScanSettings
from fusion.turntable.motion import Motion
from fusion.turntable.views import Region
from fusion.volume.forecast import choose_truncation, choose_voxel
from fusion.volume.prepared import Prepared
from fusion.volume.volume import VolumeSettings

Array = NDArray[np.float64]
MARGIN = 0.015  # [m] around what turns: mixed pixels reach so far beside it, whatever its size


def choose_volume(
    settings: ScanSettings, camera: Camera, frames: list[Prepared | None], region: Region, motion: Motion
) -> VolumeSettings:
    shown = [f for f in frames if f is not None]
    inside = shown[0].surface.points[region.holds(shown[0].surface.points)]
    distance = float(np.median(inside[:, 2])) if len(inside) else float(np.linalg.norm(motion.axis.point))
    sigma = typical_noise(frames, region)
    voxel = choose_voxel(distance, camera) if settings.voxel is None else settings.voxel
    # views that lie beside each other by more than their noise would tear a thin surface into several
    truncation = (
        choose_truncation(voxel, max(sigma, motion.spread)) if settings.truncation is None else settings.truncation
    )
    radius = motion.radius + MARGIN
    bottom = (motion.bottom if motion.plate is None else motion.plate) - MARGIN
    low, high = (-radius, -radius, bottom), (radius, radius, motion.top + MARGIN)
    return VolumeSettings(voxel, truncation, bounds=(low, high))


def typical_noise(frames: list[Prepared | None], region: Region) -> float:
    """Standard deviation of the depth on the object [m], median over some frames."""
    shown = [f for f in frames if f is not None]
    return float(np.median([np.nanmedian(f.surface.sigma[region.holds(f.surface.points)]) for f in shown[:5]]))
