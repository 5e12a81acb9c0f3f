"""How sure each vertex of a reconstruction is."""

import numpy as np
from numpy.typing import NDArray

from fusion.certainty.common import common_errors
from fusion.certainty.sigma import Causes, Sure
from fusion.certainty.vertex_sigma import blur_px, vertex_sigma_reading
from fusion.errors import RecordingError
from fusion.mesh.mesh import Mesh
from fusion.reconstruction.walk import WalkedFrames
from fusion.sensor.sensor import Sensor
from fusion.volume.prepared import Prepared
from fusion.volume.volume import VolumeSettings

Array = NDArray[np.float64]


def walk_sigma(mesh: Mesh, frames: WalkedFrames, poses: Array, given: Sensor | None, volume: VolumeSettings) -> Sure:
    """How sure each vertex is; a drift of all poses together is not in it, as no view tells it.

    Args:
        mesh: with normals.
        frames: some are read once more.
        poses: (n, 4, 4) `T_world_camera`, NaN where a frame has no place.
        given: the sensor's model, None where a usual one is assumed.
        volume: settings of what was fused.
    """
    camera = frames.recording.camera
    placed = poses[np.isfinite(poses).all(axis=(1, 2))]
    middle = mesh.vertices.mean(axis=0)
    distance = float(np.median(np.linalg.norm(placed[:, :3, 3] - middle, axis=1))) if len(placed) else 1.0
    causes = Causes(len(placed), blur_px(frames.sensor, camera), volume.voxel, common_errors(camera, given, distance))

    def read(index: int) -> Prepared | None:
        try:
            return frames[index]
        except RecordingError:
            return None

    return vertex_sigma_reading(mesh, read, poses, causes, volume.truncation)
