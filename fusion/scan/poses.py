"""Poses of the camera about the object: from the axis, tracked freely, and the gap where a turn closes."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.geometry.depth import PointMap
from fusion.geometry.trajectory import Trajectory
from fusion.progress import each
from fusion.recording.recording import Recording
from fusion.tracking.equations import lay_out
from fusion.tracking.icp import IcpResult, IcpSettings, align
from fusion.tracking.pairs import EFFECTIVE
from fusion.turntable.axis import Axis
from fusion.turntable.focal import SURE
from fusion.turntable.jumps import Jump
from fusion.turntable.motion import Motion
from fusion.turntable.views import Region
from fusion.turntable.wobble import rocking
from fusion.volume.prepared import Prepared, fuse
from fusion.volume.volume import Volume, VolumeSettings

Array = NDArray[np.float64]
TRACKING = IcpSettings(
    points=(2000, 8000, 40000), reaches=(0.02, 0.012, 0.008), iterations=(6, 5, 4), min_inlier_share=0.3
)


def about_axis(axis: Axis, angles: Array, shifts: Array | None = None) -> Array:
    """The camera in the object's frame (n, 4, 4), NaN where the angle is NaN.

    Args:
        axis: about which the object turns.
        angles: (n,) [rad].
        shifts: (n, 2) across the axis [m], where a hand moved the object too (see `Motion`).
    """
    T_object_camera = axis.object_frame()
    poses = np.full((len(angles), 4, 4), np.nan)
    moved = np.zeros((len(angles), 2)) if shifts is None else shifts
    for i in np.flatnonzero(np.isfinite(angles)):
        back = axis.turn(-float(angles[i]))
        back[:3, 3] -= back[:3, :3] @ (moved[i] @ axis.across())
        poses[i] = T_object_camera @ back
    return poses


def constrained(recording: Recording, motion: Motion) -> Trajectory:
    """The camera in the object's frame, by the axis and the angles that were found."""
    return Trajectory(recording.timestamps, about_axis(motion.axis, motion.angles, motion.shifts))


def track_freely(
    frames: list[Prepared | None], region: Region, start: Trajectory, volume_settings: VolumeSettings
) -> tuple[Trajectory, Array, Array, Volume]:
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
    return Trajectory(start.timestamps, poses), residual, share, volume


def model(volume: Volume, camera: Camera, T_object_camera: Array) -> PointMap:
    """What a camera should see of the volume."""
    seen = volume.raycast(camera, T_object_camera)
    return PointMap(camera, seen.points, seen.normals, np.where(np.isfinite(seen.depth), np.float32(5e-4), np.nan))


def only(surface: PointMap, region: Region) -> PointMap:
    """A surface of which only the region takes part in alignment."""
    return replace(surface, normals=np.where(region.holds(surface.points)[..., None], surface.normals, np.nan))


def align_directly(
    frames: list[Prepared | None], region: Region, guess: Trajectory, pair: tuple[int, int]
) -> Array | None:
    """`T_i_j` of two frames about a turn apart, aligned directly, no model and no axis between them."""
    found = _aligned(frames, region, guess, pair)
    return None if found is None else found.T_model_source


def _aligned(
    frames: list[Prepared | None], region: Region, guess: Trajectory, pair: tuple[int, int]
) -> IcpResult | None:
    first, second = frames[pair[0]], frames[pair[1]]
    if first is None or second is None or not np.isfinite(guess.poses[list(pair)]).all():
        return None
    T = pose.inverse(guess.poses[pair[0]]) @ guess.poses[pair[1]]
    found = align(only(second.surface, region), first.surface, T, TRACKING)
    return found if found.ok else None


def gap_of(
    trajectory: Trajectory, pair: tuple[int, int], T_direct: Array, region: Region
) -> tuple[float, float] | None:
    """How far a trajectory is from the direct alignment: angle [rad], and shift of the object's middle [m]."""
    i, j = trajectory.poses[pair[0]], trajectory.poses[pair[1]]
    if not (np.isfinite(i).all() and np.isfinite(j).all()):
        return None
    T = pose.inverse(i) @ j
    middle = (region.low + region.high) / 2
    shift = pose.transform(T, middle) - pose.transform(T_direct, middle)
    return pose.angle(pose.inverse(T_direct) @ T), float(np.linalg.norm(shift))


def confirmed(jump: Jump | None, frames: list[Prepared | None], region: Region, by_axis: Trajectory) -> Jump | None:
    """The jump, if frames before and after it show it too when they are aligned directly; its distance from them.

    Free tracking may lose its way where nothing moved; two views aligned from where the axis puts them do not. Both
    slide along surfaces that look the same there: by how much the axis fits the two views worse says whether they do.
    """
    if jump is None:
        return None
    pairs = [(jump.frame - 1 - a, jump.frame + b) for a, b in ((0, 0), (0, 1), (1, 0), (1, 1), (2, 2))]
    found = [_missed(frames, region, by_axis, (i, j)) for i, j in pairs if i >= 0 and j < len(frames)]
    known = np.array([one for one in found if one is not None]).reshape(-1, 2)
    if not len(known):
        return None
    distance, deviations = np.median(known, axis=0)
    real = distance > jump.distance / 2 and deviations > SURE
    return replace(jump, distance=float(distance)) if real else None


def _missed(
    frames: list[Prepared | None], region: Region, by_axis: Trajectory, pair: tuple[int, int]
) -> tuple[float, float] | None:
    """By how much two views miss each other on the axis: shift of the middle [m], and in standard deviations."""
    found = _aligned(frames, region, by_axis, pair)
    gap = None if found is None else gap_of(by_axis, pair, found.T_model_source, region)
    second = frames[pair[1]]
    if found is None or gap is None or second is None:
        return None
    T = pose.inverse(by_axis.poses[pair[0]]) @ by_axis.poses[pair[1]]
    centre = lay_out(only(second.surface, region), TRACKING.points[-1]).centre
    about, moved = (pose.transform(at, centre) for at in (found.T_model_source, T))
    turn = Rotation.from_matrix(T[:3, :3] @ found.T_model_source[:3, :3].T).as_rotvec()
    twist = np.concatenate([turn, moved - about])
    return gap[1], float(np.sqrt(EFFECTIVE * twist @ found.information @ twist))


def wobble(raw: Trajectory, motion: Motion) -> float:
    """Root mean square rocking of the axis over the freely tracked poses [rad]."""
    up = motion.axis.object_frame()[:3, :3] @ motion.axis.direction
    return rocking(raw.poses[:, :3, :3], up).rms
