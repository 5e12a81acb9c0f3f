"""How sure each vertex of a reconstruction is."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.certainty.common import common_errors
from fusion.certainty.sigma import Causes, Sure
from fusion.certainty.vertex_sigma import blur_px, vertex_sigma_reading
from fusion.errors import RecordingError
from fusion.mesh.mesh import Mesh
from fusion.reconstruction.changed import Changed
from fusion.reconstruction.focal_length import FocalSeen
from fusion.reconstruction.loops.network import PoseErrors
from fusion.reconstruction.walk import WalkedFrames
from fusion.sensor.sensor import Sensor
from fusion.volume.prepared import Prepared
from fusion.volume.volume import VolumeSettings

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FusedWith:
    """What a mesh was fused with."""

    given: Sensor | None  # the sensor's model; None where a usual one is assumed
    volume: VolumeSettings
    focal: FocalSeen | None  # what landmarks say of the camera


def walk_sigma(
    mesh: Mesh, frames: WalkedFrames, poses: Array, errors: PoseErrors | None, made: FusedWith, changed: Changed
) -> Sure:
    """How sure each vertex is.

    Args:
        frames: some are read once more; `changed` looks at them too.
        poses: (n, 4, 4) `T_world_camera`, NaN where a frame has no place.
        errors: what all poses may be wrong by together; None where nothing tells it.
    """
    camera = frames.recording.camera
    placed = poses[np.isfinite(poses).all(axis=(1, 2))]
    middle = mesh.vertices.mean(axis=0)
    distance = float(np.median(np.linalg.norm(placed[:, :3, 3] - middle, axis=1))) if len(placed) else 1.0
    seen = None if made.focal is None else (made.focal.stated_std, np.inf)
    common = common_errors(camera, made.given, distance, seen)
    pose = None if errors is None else errors.along
    causes = Causes(len(placed), blur_px(frames.sensor, camera), made.volume.voxel, common, pose)

    def read(index: int) -> Prepared | None:
        try:
            frame = frames[index]
        except RecordingError:
            return None
        changed.look(index, frame)
        return frame

    return vertex_sigma_reading(mesh, read, poses, causes, made.volume.truncation)
