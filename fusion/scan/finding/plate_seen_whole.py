"""Is what lies below a slab that turns a table, or a round plate whose rim lies beyond the window of the object?"""

from dataclasses import replace

import numpy as np

from fusion.errors import RecordingError
from fusion.recording.recording import Recording
from fusion.sensor.sensor import Sensor
from fusion.turntable.motion import Motion
from fusion.turntable.table.plate import has_a_rim
from fusion.turntable.views import ObjectView
from fusion.volume.prepared import prepare

FRAMES = 8  # whole images that are looked at: a rim stands still in all of them


def on_its_plate(motion: Motion, recording: Recording, sensor: Sensor) -> Motion:
    """The motion with a round plate where its rim is seen in the whole images: the slab upon it is the object's own.

    Args:
        motion: its slab was found in windows around what turns; a round plate does not turn visibly and may go on.
        recording: with corrected depth.
        sensor: rates the pixels.
    """
    if motion.table is None:
        return motion
    views, nothing = [], np.zeros((0, 3), np.float32)
    for index in np.unique(np.linspace(0, len(recording) - 1, FRAMES).round().astype(int)):
        try:
            whole = prepare(recording[int(index)], recording.camera, sensor).surface
        except RecordingError:  # told when all frames are loaded
            continue
        views.append(ObjectView(whole, nothing, nothing, nothing[:, 0]))
    if not views or not has_a_rim(views, motion.axis, motion.table, motion.size):
        return motion
    lower = motion.table
    axis = replace(motion.axis, point=motion.axis.point + lower * motion.axis.direction)
    bottom, top = motion.bottom - lower, motion.top - lower
    return replace(motion, axis=axis, table=None, plate_thickness=0.0, bottom=bottom, top=top)
