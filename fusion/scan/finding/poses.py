"""Poses of the camera about the object: from the axis, and tracked freely."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.geometry.depth import PointMap
from fusion.geometry.trajectory import Trajectory
from fusion.progress import each
from fusion.recording.recording import Recording
from fusion.tracking.icp import IcpSettings, align
from fusion.turntable.axis import about_axis
from fusion.turntable.motion import Motion
from fusion.turntable.views import Region
from fusion.turntable.wobble import rocking
from fusion.volume.prepared import Prepared, fuse
from fusion.volume.volume import Volume, VolumeSettings

Array = NDArray[np.float64]
TRACKING = IcpSettings(
    points=(2000, 8000, 40000), reaches=(0.02, 0.012, 0.008), iterations=(6, 5, 4), min_inlier_share=0.3
)


def constrained(recording: Recording, motion: Motion) -> Trajectory:
    """The camera in the object's frame, by the axis and the angles that were found."""
    return Trajectory(recording.timestamps, about_axis(motion.axis, motion.angles, motion.shifts))


@dataclass(frozen=True)
class FreeCourse:
    """Frames tracked freely: their poses, residual (n,) [m] and share of inliers (n,), and the volume of them."""

    course: Trajectory
    residual: Array
    inlier_share: Array
    volume: Volume


def track_freely(
    frames: list[Prepared | None], region: Region, start: Trajectory, volume_settings: VolumeSettings
) -> FreeCourse:
    """Every frame against the model so far, all six directions free; the joint fit only says where to look first."""
    poses = np.full_like(start.poses, np.nan)
    residual, share = np.full((2, len(frames)), np.nan)
    volume = Volume(volume_settings)
    last = -1
    for i, frame in enumerate(each(frames, "tracking")):
        if frame is None or not np.isfinite(start.poses[i]).all():
            continue
        T = start.poses[i]
        if last >= 0:
            T = poses[last] @ pose.inverse(start.poses[last]) @ start.poses[i]
            found = align(only(frame.surface, region), model(volume, frame.surface.camera, T), np.eye(4), TRACKING)
            residual[i], share[i] = found.residual, found.inlier_share
            if not found.ok:
                continue
            T = T @ found.T_model_source
        poses[i], last = T, i
        fuse(volume, frame, T)
    return FreeCourse(Trajectory(start.timestamps, poses), residual, share, volume)


def model(volume: Volume, camera: Camera, T_object_camera: Array) -> PointMap:
    """What a camera should see of the volume."""
    seen = volume.raycast(camera, T_object_camera)
    return PointMap(camera, seen.points, seen.normals, np.where(np.isfinite(seen.depth), np.float32(5e-4), np.nan))


def only(surface: PointMap, region: Region) -> PointMap:
    """A surface of which only the region takes part in alignment."""
    return replace(surface, normals=np.where(region.holds(surface.points)[..., None], surface.normals, np.nan))


def wobble(raw: Trajectory, motion: Motion) -> float:
    """Root mean square rocking of the axis over the freely tracked poses [rad]."""
    up = motion.axis.object_frame()[:3, :3] @ motion.axis.direction
    return rocking(raw.poses[:, :3, :3], up).rms
