"""Object or room, and which voxels, truncation and memory that takes: before the start, and by the camera's course."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fusion.errors import RecordingError
from fusion.geometry.pose import Array, transform
from fusion.reconstruction.settings import ReconstructSettings
from fusion.reconstruction.walked_round import StandingView, seen_by, walked_round
from fusion.recording.recording import Recording
from fusion.sensor.sensor import Sensor
from fusion.volume.blocks import FullError
from fusion.volume.forecast import choose_truncation, choose_voxel, forecast_bytes
from fusion.volume.prepared import NOISIEST, Prepared, prepare
from fusion.volume.settings import VolumeSettings
from fusion.volume.subject import MIDDLE, ROOM, Subject, subject_of

PROBES = 9  # frames looked at before the start, to choose voxels and to forecast the memory
GROWN = 2.0  # so much more than one view may all views of an object show, its surroundings among them (guess)
SHOWN = 400  # points of a view say how large all is
MUCH = 0.25  # of the memory for one view alone: a scan shows several times as much (guess)


@dataclass(frozen=True)
class Plan:
    """How a recording is fused."""

    subject: Subject  # what is scanned
    reason: str  # why it is taken for an object or a room
    volume: VolumeSettings  # voxels, truncation, limits
    warnings: tuple[tuple[str, str], ...] = ()  # (severity, sentence)

    @property
    def kind(self) -> str:
        return "room" if self.subject.room else "object"


def plan(recording: Recording, settings: ReconstructSettings, sensor: Sensor) -> Plan:
    """Voxel and truncation that suit a recording; what one view takes must fit into memory.

    Raises:
        RecordingError: no frame, or none that can be read or shows a surface.
        VolumeError: the voxel settings make no sense or do not fit into memory.
    """
    probes = _probe(recording, settings, sensor)
    subject = subject_of(probes, settings.room)
    reason = subject.reason if settings.room is None else "as told"
    volume = _volume(recording, settings, subject)
    needed = _needed(volume, probes)
    free = settings.room is None and settings.voxel is None and not subject.room
    if free and needed > MUCH * settings.max_bytes:
        reason = f"voxels of {volume.voxel * 1e3:g} mm would take {needed / 2**20:.0f} MiB for one view"
        subject = replace(subject, room=True)
        volume = _volume(recording, settings, subject)
        needed = _needed(volume, probes)
    chosen = Plan(subject, reason, volume, _memory(needed, volume, recording))
    if settings.poses is None:
        return chosen
    poses = settings.poses.at(np.array([p.frame.timestamp for p in probes])).poses
    views = [StandingView(T, p.surface) for T, p in zip(poses, probes, strict=True) if np.isfinite(T).all()]
    if views:
        shown = np.concatenate([seen_by(view, SHOWN)[0] for view in views])
        chosen = room_after_all(chosen, recording, settings, shown) or chosen
    return object_after_all(chosen, recording, settings, views) or chosen


def room_after_all(plan: Plan, recording: Recording, settings: ReconstructSettings, points: Array) -> Plan | None:
    """Another plan, where a walk has shown more than an object with its surroundings; None where this one stays.

    Single frames of a room may show as little as those of an object do.

    Args:
        points: (n, 3) some of all that was seen so far, in one frame [m].
    """
    if _told(settings) or plan.subject.room or plan.subject.free:
        return None
    size = float(np.ptp(np.percentile(points, MIDDLE, axis=0), axis=0).max())
    if size < GROWN * ROOM:
        return None
    subject = replace(plan.subject, room=True, size=size)
    volume = _volume(recording, settings, subject)
    return Plan(subject, f"the walk shows {size:.2f} m", volume, plan.warnings)


def object_after_all(
    plan: Plan, recording: Recording, settings: ReconstructSettings, views: Sequence[StandingView]
) -> Plan | None:
    """Another plan, where the camera went round one thing in a room; None where this one stays.

    Single frames of a thing on a table show the room behind it, and all frames the whole room.

    Args:
        views: some of the recording, spread over it.
    """
    found = None if _told(settings) or not plan.subject.room else walked_round(views)
    if found is None:
        return None
    subject, reach = found.subject, GROWN * found.subject.size
    reason = f"the camera went round what is {subject.size:.2f} m large, at {subject.distance:.2f} m"
    volume = _volume(recording, settings, subject)
    if settings.box is None:  # in voxels this small, nobody wants the room around
        low, high = (tuple((found.middle + side * reach).tolist()) for side in (-1, 1))
        volume = replace(volume, bounds=(low, high))
        reason += f", and what is farther than {reach:.1f} m from it is left out"
    if max(_taken(volume, view) for view in views) > MUCH * settings.max_bytes:
        return None
    return Plan(subject, reason, volume)


def _told(settings: ReconstructSettings) -> bool:
    """The voxels, or what they depend on, are not for the frames to say."""
    return settings.room is not None or settings.voxel is not None or settings.truncation is not None


def _volume(recording: Recording, settings: ReconstructSettings, subject: Subject) -> VolumeSettings:
    voxel = settings.voxel or choose_voxel(
        subject.distance, recording.camera, subject.room
    )  # 0 is refused in the settings
    truncation = settings.truncation or choose_truncation(voxel, subject.sigma)
    return VolumeSettings(voxel, truncation, bounds=settings.box, max_bytes=settings.max_bytes)


def _needed(volume: VolumeSettings, probes: list[Prepared]) -> int:
    """Bytes that the view with most surface takes; 0 in a box, whose part of the view is not known yet."""
    return 0 if volume.bounds is not None else max(_taken(volume, StandingView(np.eye(4), p.surface)) for p in probes)


def _taken(volume: VolumeSettings, view: StandingView) -> int:
    """Bytes that a view takes."""
    surface = view.surface
    usable = surface.sigma < NOISIEST * volume.truncation
    if volume.bounds is not None:
        points = transform(view.T_world_camera, surface.points.astype(float))
        usable &= ((points > volume.bounds[0]) & (points < volume.bounds[1])).all(axis=-1)
    return forecast_bytes(volume, np.where(usable, surface.points[..., 2], np.nan), surface.camera)


def _memory(needed: int, volume: VolumeSettings, recording: Recording) -> tuple[tuple[str, str], ...]:
    if needed > volume.max_bytes:
        fits = volume.voxel * np.sqrt(needed / volume.max_bytes)
        raise FullError(
            "the volume will not fit into its memory",
            recording.path,
            f"{needed / 2**20:.0f} MiB for one view with voxels of {volume.voxel * 1e3:g} mm",
            f"at most {volume.max_bytes / 2**20:.0f} MiB",
            f"pass --voxel {np.ceil(fits * 4000) / 4000:g} or more, --room, --box, --max-depth, or --memory (tiles)",
        )
    if needed > MUCH * volume.max_bytes:
        text = f"one view alone takes {needed / 2**20:.0f} MiB of {volume.max_bytes / 2**20:.0f} MiB"
        return (("warning", f"memory: {text}; --room, --box or --max-depth need less"),)
    return ()


def _probe(recording: Recording, settings: ReconstructSettings, sensor: Sensor) -> list[Prepared]:
    """A few frames that show a surface, spread over the recording."""
    if not len(recording):
        raise RecordingError("the recording has no frames", recording.path)
    found, broken = [], None
    for index in np.unique(np.linspace(0, len(recording) - 1, PROBES).round().astype(int)):
        try:
            prepared = prepare(recording[int(index)], recording.camera, sensor, max_depth=settings.max_depth)
        except RecordingError as error:
            broken = broken or error
            continue
        if np.isfinite(prepared.depth).any():
            found.append(prepared)
    if not found:
        if broken is not None:
            raise broken
        raise RecordingError(
            "no depth in the recording", recording.path, "only missing pixels",
            do="check the depth files, depth_scale and --max-depth",
        )  # fmt: skip
    return found
