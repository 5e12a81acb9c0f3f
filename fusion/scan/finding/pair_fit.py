"""The motion by pairs of views."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.errors import TrackingError
from fusion.geometry.camera import Camera
from fusion.progress import stage
from fusion.recording.ahead import side_by_side
from fusion.recording.recording import Recording
from fusion.scan.settings import ScanSettings
from fusion.sensor.correction.unit import depth_std, tilt_std
from fusion.sensor.sensor import Sensor
from fusion.turntable.axis import Turns
from fusion.turntable.guess.told_step import GOOD, neighbours_misfit, rather_alone, refuse_contradicted_step
from fusion.turntable.motion import Motion, estimate_motion
from fusion.turntable.selfcheck import DepthKnown
from fusion.turntable.views import ObjectView, Region, usable, view
from fusion.volume.prepared import Prepared

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


@dataclass(frozen=True)
class PairFit:
    """What pairs of views say."""

    motion: Motion  # of the table
    commanded: Array | None  # (n,) told angles [rad] that it follows, or None
    known: DepthKnown | None  # how well the depth is known; None where no calibration says it


def fit_pairs(
    frames: list[Prepared | None], asked: Asked, region: Region, commanded: Array | None, start: Motion | None = None
) -> PairFit:
    """The motion by pairs of views.

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
    settings, camera = asked.settings, asked.recording.camera
    cut = region.cut(region.window(camera))
    marks = {} if region.below is None else region.below.marks

    def view_of(index: int) -> ObjectView:
        f = frames[index]
        if f is None:
            return _nothing(frames)
        return view(f.surface, usable(f.surface, cut), f.color, marks.get(index))

    views = side_by_side(view_of, range(len(frames)))
    with stage("motion"):
        if settings.step is not None and not settings.force:
            refuse_contradicted_step([v.plain() for v in views], cut, settings.step)
        known = None if settings.sensor is None else _known(settings.sensor, camera, region)
        motion, commanded = _motion(views, cut, _Known(commanded, known, settings.step is None), start)
    if start is not None:
        left_out = motion.print_contradicts or start.print_contradicts
        motion = replace(motion, rejected={**motion.rejected, **start.rejected}, print_contradicts=left_out)
    return PairFit(motion, commanded, known)


def _known(sensor: Sensor, camera: Camera, region: Region) -> DepthKnown | None:
    """How well the depth is known where the object stands; None where no calibration says it."""
    std = depth_std(sensor, camera, float((region.low[2] + region.high[2]) / 2))
    if std is None:
        return None
    left = sensor.depth_errors

    def errors(points: Array) -> Array:
        assert left is not None
        u, v = camera.project(points).T
        return left.at(u, v, points[:, 2])

    return DepthKnown(std, tilt_std(sensor, camera), None if left is None else errors)


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
    except TrackingError as error:
        if commanded is None:
            raise
        if not logged:
            do = f"try it without --step, which may be the other way round or another one; {error.do}"
            raise TrackingError(error.what, error.where, error.found, error.expected, do) from error
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


def _nothing(frames: list[Prepared | None]) -> ObjectView:
    first = next((f for f in frames if f is not None), None)
    if first is None:
        raise TrackingError("no frame of the recording can be read")
    none = np.zeros((0, 3), np.float32)
    return ObjectView(first.surface, none, none, np.zeros(0, np.float32))
