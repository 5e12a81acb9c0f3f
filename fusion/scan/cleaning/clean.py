"""The mesh of the object alone: without plate, crumbs and small holes."""

from dataclasses import dataclass, replace

import numpy as np

from fusion.errors import TrackingError
from fusion.mesh.cleanup import fill_small_holes, large_parts
from fusion.mesh.mesh import Mesh
from fusion.mesh.shape import CRUMB
from fusion.mesh.vertices import vertices_kept
from fusion.scan.cleaning.off_plate import clear_of_rounding, fitted_plate, off_plate
from fusion.scan.finding.object import MARGIN
from fusion.scan.settings import ScanSettings
from fusion.turntable.motion import Motion


@dataclass(frozen=True)
class Cleaned:
    """The object alone."""

    mesh: Mesh  # without plate, flying parts and small holes
    kept: float  # share of the surface that these are
    # so far above the plate it cannot be told from it, and its sides are carried down [m]; 0: nothing is cut
    hidden: float = 0.0


def clean(mesh: Mesh, settings: ScanSettings, motion: Motion, voxel: float) -> Cleaned:
    """The object alone, of a surface that was made with a voxel [m]."""
    if motion.plate is None or settings.keep_plate or mesh.normals is None:
        if settings.keep_plate:  # the volume is square, what turns is not
            mesh = vertices_kept(mesh, np.hypot(*mesh.vertices[:, :2].T) <= motion.radius + MARGIN)
        found = Cleaned(*large_parts(mesh, CRUMB))
    else:
        plate = clear_of_rounding(mesh, fitted_plate(mesh, voxel, motion.size, motion.table), voxel)
        found = Cleaned(*off_plate(mesh, plate), plate.hidden)
    if not len(found.mesh.faces):
        raise TrackingError("nothing is left of the object", do="pass --keep-plate, or give --box")
    if settings.fill_holes > 0:
        return replace(found, mesh=fill_small_holes(found.mesh, settings.fill_holes))
    return found
