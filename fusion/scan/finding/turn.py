"""The motion of a scan: between pairs of frames first, then of every frame against the model of all."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.errors import TrackingError
from fusion.geometry.camera import Camera
from fusion.progress import each, stage
from fusion.recording.recording import Recording
from fusion.scan.finding.frames import object_alone
from fusion.scan.finding.object import choose_volume
from fusion.scan.finding.poses import about_axis
from fusion.scan.finding.relieved import relieved
from fusion.scan.settings import ScanSettings
from fusion.sensor.correction.calibrated import depth_std, tilt_std
from fusion.sensor.sensor import Sensor
from fusion.turntable.all_views.log import with_log
from fusion.turntable.axis import Axis, Turns
from fusion.turntable.guess.told_step import GOOD, neighbours_misfit, rather_alone, refuse_contradicted_step
from fusion.turntable.model.finish import How, finish
from fusion.turntable.model.rays import Rays, rays_of
from fusion.turntable.motion import Motion, estimate_motion
from fusion.turntable.selfcheck import DepthKnown, SelfCheck, prior_of
from fusion.turntable.views import ObjectView, Region, usable, view
from fusion.volume.prepared import Prepared, fuse
from fusion.volume.volume import Volume, VolumeSettings

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Asked:
    """What is scanned, and how: the recording, its sensor and the settings."""

    recording: Recording
    sensor: Sensor
    settings: ScanSettings


class _Known(NamedTuple):
    """Told angles (n,) [rad], how well the depth is known, and whether the angles are of a log."""

    commanded: Array | None
    depth: DepthKnown | None
    logged: bool


def find_motion(
    frames: list[Prepared | None],
    asked: Asked,
    region: Region,
    commanded: Array | None,
    start: Motion | None = None,
) -> Motion:
    """Axis and angles: by pairs of views, then of every frame against the model of all.

    Args:
        frames: cut to the window of the region.
        asked: recording and settings.
        region: where the object is.
        commanded: (n,) angles [rad] as told, or None.
        start: a motion that was found before, see `estimate_motion`.

    Raises:
        RecordingError: the images contradict the step that was told.
        TrackingError: no frame can be read, or nothing turns about one axis.
    """
    camera, settings = asked.recording.camera, asked.settings
    cut = region.cut(region.window(camera))
    pixels = [None if f is None else usable(f.surface, cut) for f in frames]
    both = list(zip(frames, pixels, strict=True))
    views = [_nothing(frames) if f is None or p is None else view(f.surface, p, f.color) for f, p in both]
    with stage("motion"):
        if settings.step is not None and not settings.force:
            refuse_contradicted_step(views, cut, settings.step)
        known = None if settings.sensor is None else _known(settings.sensor, camera, region)
        motion, commanded = _motion(views, cut, _Known(commanded, known, settings.step is None), start)
    # a model is sharp only where camera and depth fit the motion, and it has one axis
    if motion.shifts is None and (motion.camera_check.values == motion.taken_out.values).all():
        rays = [None if f is None or p is None else rays_of(f.surface, p) for f, p in both]
        with stage("motion"):
            frames = object_alone(frames, cut, motion)
            volume = choose_volume(settings, camera, frames, cut, motion)
            doubt = None if known is None else prior_of(camera, known)
            motion = _finished(frames, rays, volume, motion, How(held=motion.held, doubt=doubt))
    if commanded is not None:
        motion = replace(motion, angles=with_log(motion.angles, motion.angle_std, commanded))
    return motion


def _known(sensor: Sensor, camera: Camera, region: Region) -> DepthKnown | None:
    """How well the depth is known where the object stands; None where no calibration says it."""
    std = depth_std(sensor, camera, float((region.low[2] + region.high[2]) / 2))
    return None if std is None else DepthKnown(std, tilt_std(sensor, camera))


def _motion(
    views: list[ObjectView],
    region: Region,
    known: _Known,
    start: Motion | None = None,
) -> tuple[Motion, Array | None]:
    """The motion between the views, and the told angles that it follows.

    Where a log leads nowhere, or the images alone fit clearly better, as beside one in radians, they are asked alone;
    what is wrong with it shows then.
    """
    commanded, depth, logged = known
    told = None
    try:
        told = estimate_motion(views, region, commanded, depth, start)
        if commanded is None or not logged or neighbours_misfit(views, _turns(told)) < GOOD:
            return told, commanded
    except TrackingError:
        if commanded is None or not logged:
            raise
    try:
        alone = estimate_motion(views, region, None, depth, start)
    except TrackingError:
        if told is None:
            raise
        return told, commanded
    if told is None or rather_alone(views, _turns(told), _turns(alone)):
        return alone, None
    return told, commanded


def _turns(motion: Motion) -> Turns:
    return Turns(motion.axis, motion.angles)


def _finished(
    frames: list[Prepared | None], rays: list[Rays | None], settings: VolumeSettings, motion: Motion, how: How
) -> Motion:
    def model_of(axis: Axis, angles: Array, check: SelfCheck) -> Volume:
        volume = Volume(settings)
        for frame, T in zip(each(relieved(frames, check), "model"), about_axis(axis, angles), strict=True):
            if frame is not None and np.isfinite(T).all():
                fuse(volume, frame, T)
        return volume

    found = finish(rays, Turns(motion.axis, motion.angles), model_of, motion.taken_out, how)
    std = motion.angle_std if motion.held else found.angle_std
    moved = replace(motion, axis=found.axis, angles=found.angles, angle_std=std, axis_std=found.axis_std)
    return replace(moved, camera_check=found.check, taken_out=found.check, size_std=found.size_std)


def _nothing(frames: list[Prepared | None]) -> ObjectView:
    first = next((f for f in frames if f is not None), None)
    if first is None:
        raise TrackingError("no frame of the recording can be read")
    none = np.zeros((0, 3), np.float32)
    return ObjectView(first.surface, none, none, np.zeros(0, np.float32))
