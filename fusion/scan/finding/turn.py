"""The motion of a scan: between pairs of frames first, then of every frame against the model of all."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.scan.finding.alone import object_alone
from fusion.scan.finding.model_fit import fit_model
from fusion.scan.finding.pair_fit import Asked, fit_pairs
from fusion.scan.finding.passing import without_passing
from fusion.scan.finding.plate_seen_whole import on_its_plate
from fusion.turntable.all_views.log import with_log
from fusion.turntable.axis import about_axis
from fusion.turntable.motion import Motion
from fusion.turntable.views import Region
from fusion.volume.prepared import Prepared

Array = NDArray[np.float64]


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
    fit = fit_pairs(frames, asked, region, commanded, start)
    motion, commanded = fit_model(frames, asked, region, fit), fit.commanded
    if commanded is not None:
        motion = replace(motion, angles=with_log(motion.angles, motion.angle_std, commanded))
    return motion


@dataclass(frozen=True)
class MotionAlone:
    """A motion, the frames of the object alone, and the share of them before which something passed."""

    motion: Motion
    frames: list[Prepared | None]
    passed: float


def motion_alone(
    frames: list[Prepared | None],
    asked: Asked,
    region: Region,
    told: NDArray[np.float64] | None,
    start: Motion | None = None,
) -> MotionAlone:
    motion = find_motion(frames, asked, region, told, start)
    if start is not None:
        motion = replace(motion, rejected={**motion.rejected, **start.rejected})
    motion = on_its_plate(motion, asked.recording, asked.sensor)
    cut = region.cut(region.window(asked.recording.camera))
    alone = object_alone(frames, cut, motion)
    clean = without_passing(alone, cut, about_axis(motion.axis, motion.angles, motion.shifts))
    changed = [a is not b for a, b in zip(alone, clean, strict=True)]
    return MotionAlone(motion, clean, float(np.mean(changed)))
