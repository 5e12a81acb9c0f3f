"""The object alone: the volume around it, and its mesh without plate, crumbs and small holes."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.errors import TrackingError
from fusion.geometry.camera import Camera
from fusion.mesh.cleanup import fill_small_holes, large_parts
from fusion.mesh.mesh import Mesh
from fusion.mesh.shape import CRUMB
from fusion.mesh.vertices import vertices_kept
from fusion.scan.finding.off_plate import fitted_plate, off_plate
from fusion.scan.settings import ScanSettings
from fusion.turntable.motion import Motion
from fusion.turntable.views import Region
from fusion.volume.forecast import choose_truncation, choose_voxel
from fusion.volume.prepared import Prepared
from fusion.volume.volume import VolumeSettings

Array = NDArray[np.float64]
MARGIN = 0.015  # [m] around what turns


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


@dataclass(frozen=True)
class Cleaned:
    """The object alone.

    Attributes:
        mesh: without plate, flying parts and small holes.
        kept: share of the surface that these are.
        hidden: so far above the plate it cannot be told from it, and its sides are carried down [m]; 0: nothing is cut.
    """

    mesh: Mesh
    kept: float
    hidden: float = 0.0


def clean(mesh: Mesh, settings: ScanSettings, motion: Motion, voxel: float) -> Cleaned:
    """The object alone, of a surface that was made with a voxel [m]."""
    if motion.plate is None or settings.keep_plate or mesh.normals is None:
        if settings.keep_plate:  # the volume is square, what turns is not
            mesh = vertices_kept(mesh, np.hypot(*mesh.vertices[:, :2].T) <= motion.radius + MARGIN)
        found = Cleaned(*large_parts(mesh, CRUMB))
    else:
        plate = fitted_plate(mesh, voxel, motion.table)
        found = Cleaned(*off_plate(mesh, plate), plate.hidden)
    if not len(found.mesh.faces):
        raise TrackingError("nothing is left of the object", do="pass --keep-plate, or give --box")
    if settings.fill_holes > 0:
        return replace(found, mesh=fill_small_holes(found.mesh, settings.fill_holes))
    return found
