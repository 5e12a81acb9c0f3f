"""The motion, and the frames of the object alone that it tells."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.scan.finding.alone import object_alone
from fusion.scan.finding.passing import without_passing
from fusion.scan.finding.plate_seen_whole import on_its_plate
from fusion.scan.finding.turn import Asked, find_motion
from fusion.turntable.axis import about_axis
from fusion.turntable.motion import Motion
from fusion.turntable.views import Region
from fusion.volume.prepared import Prepared


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
