"""One volume of all frames of all passes."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fusion.errors import TrackingError
from fusion.geometry import pose
from fusion.mesh.cleanup import fill_small_holes, large_parts
from fusion.mesh.mesh import Mesh
from fusion.mesh.shape import CRUMB
from fusion.mesh.vertices import vertices_kept
from fusion.passes.object_alone import CELL, Near, cut, parts_alone
from fusion.passes.one_pass import Pass
from fusion.passes.settings import MergeSettings
from fusion.progress import each, stage
from fusion.scan.cleaning.seen import looked_through
from fusion.volume.prepared import Prepared, fuse
from fusion.volume.volume import Volume, VolumeSettings

Array = NDArray[np.float64]
LOWEST = 0.2  # percentile of a mesh's heights that is its foot


def fused(passes: Sequence[Pass], T: Array, settings: MergeSettings) -> tuple[Mesh, VolumeSettings]:
    """The object alone, in the first pass's frame, integrated from all frames.

    Args:
        passes: k of them.
        T: (k, 4, 4) from each one's frame to the first's.
        settings: what was asked for.

    Raises:
        TrackingError: nothing of the object is left.
        VolumeError: the voxel settings do not fit into memory.
    """
    voxel = settings.voxel or min(one.voxel for one in passes)
    truncation = settings.truncation or max(one.truncation for one in passes)
    with stage("object"):
        alone = parts_alone(passes, T)
        points = np.concatenate([pose.transform(T[i], mesh.vertices) for i, mesh in enumerate(alone)])
        near = Near.of(points, CELL * voxel, truncation)
        floors = [
            float(np.percentile(m.vertices[:, 2], LOWEST)) + one.hidden for m, one in zip(alone, passes, strict=True)
        ]
    chosen = VolumeSettings(voxel, truncation, bounds=(_corner(near.low), _corner(near.high)))
    volume = Volume(chosen)
    frames, poses = [], []
    for i, k, frame in each(
        [(i, k, f) for i, one in enumerate(passes) for k, f in enumerate(one.frames)], "integrating"
    ):
        own = passes[i].trajectory.poses[k]
        if frame is None or not np.isfinite(own).all():
            continue
        fuse(volume, cut(frame, own, T[i], near, floors[i]), T[i] @ own)
        frames.append(frame)
        poses.append(T[i] @ own)
    with stage("mesh"):
        return _clean(volume.surface(), frames, np.array(poses), chosen, settings), chosen


def _clean(mesh: Mesh, frames: list[Prepared], poses: Array, chosen: VolumeSettings, settings: MergeSettings) -> Mesh:
    if len(mesh.faces):
        mesh = vertices_kept(mesh, ~looked_through(mesh, frames, poses, chosen.truncation))
    if not len(mesh.faces):
        raise TrackingError("nothing is left of the object that the passes share")
    mesh = large_parts(mesh, CRUMB)[0]
    return fill_small_holes(mesh, settings.fill_holes) if settings.fill_holes > 0 else mesh


def _corner(point: Array) -> tuple[float, float, float]:
    x, y, z = point.tolist()
    return x, y, z
