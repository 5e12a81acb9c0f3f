"""How sure each vertex of a turntable scan is."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.certainty.common import common_errors
from fusion.certainty.looks import Looks
from fusion.certainty.sigma import Causes, Sure
from fusion.certainty.vertex_sigma import blur_px, vertex_sigma
from fusion.geometry.camera import Camera
from fusion.mesh.mesh import Mesh
from fusion.sensor.sensor import Sensor
from fusion.turntable.all_views.camera_fit import SYSTEMATIC
from fusion.turntable.focal import FocalCheck
from fusion.turntable.motion import Motion
from fusion.turntable.selfcheck import PRIOR
from fusion.volume.prepared import Prepared
from fusion.volume.volume import VolumeSettings

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MadeWith:
    """What a scan was made with."""

    camera: Camera  # as used
    focal: FocalCheck  # what the scan says of its focal length
    sensor: Sensor  # that rated the pixels; `given`: the one that was given, or None
    given: Sensor | None
    volume: VolumeSettings  # its settings


def scan_sigma(
    mesh: Mesh,
    frames: list[Prepared | None],
    poses: Array,
    used: MadeWith,
    motion: Motion,
) -> Sure:
    """How sure each vertex is.

    Args:
        mesh: of the object, with normals.
        frames: (n) as they were fused.
        poses: (n, 4, 4) `T_object_camera`.
        used: camera, sensor and volume.
        motion: of the table.
    """
    camera, sensor, volume = used.camera, used.sensor, used.volume
    distance = float(np.linalg.norm(motion.axis.point))
    seen = float(np.hypot(used.focal.std, SYSTEMATIC)), float(PRIOR[0])
    common = replace(common_errors(camera, used.given, distance, seen), size=motion.size_std)
    causes = Causes(len(frames), blur_px(sensor, camera), volume.voxel, common, axis_errors(motion, poses))
    return vertex_sigma(mesh, frames, poses, causes, volume.truncation)


def axis_errors(motion: Motion, poses: Array) -> Callable[[Array, Array, Looks], Array] | None:
    """What an axis that is not quite where it was fitted does along the normals; None where nothing tells how well.

    Errors of single angles are not in it: they differ from view to view, and are in what views differ by.

    Args:
        motion: of the table.
        poses: (n, 4, 4) `T_object_camera`.
    """
    std = motion.axis_std
    if std is None or not np.isfinite(std).all():
        return None
    placed = poses[np.isfinite(poses).all(axis=(1, 2))]

    def along(points: Array, normals: Array, looks: Looks) -> Array:
        """Standard deviation (m,) [m]; an error of the axis turns with the camera, so views from all around differ."""
        share = looks.share().astype(float)
        first = motion.axis.object_frame()[:3, :3]
        out = np.zeros((len(points), len(std)))
        for k, T in enumerate(looks.poses if len(placed) else ()):
            back = T[:3, :3] @ first.T  # from the object's frame at the first angle to the object as it stands turned
            there, facing = points @ back, normals @ back
            sides = np.eye(3)[:2]
            tilts = [np.einsum("ij,ij->i", np.cross(side, there), facing) for side in sides]
            out += share[:, k, None] * np.column_stack([*tilts, *(facing @ side for side in sides)])
        return np.asarray(np.sqrt(np.sum((out * std) ** 2, axis=1)))

    return along
