"""A recording as an ideal sensor would have made it: corrected frame by frame, with the true camera."""

from dataclasses import replace

import numpy as np

from fusion.errors import RecordingError
from fusion.recording.recording import Frame, Recording
from fusion.sensor.correction.correction import corrected_image, true_camera
from fusion.sensor.correction.summary import CorrectionSummary, tell
from fusion.sensor.moments import moments_of
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View

LOOKED_AT = 8  # frames, until one shows a surface


def corrected_recording(recording: Recording, sensor: Sensor) -> tuple[Recording, CorrectionSummary]:
    """The recording with corrected depth and the true camera, and what was done.

    Frames are corrected when they are loaded. What cannot be read is told by the frame that is asked for.
    """
    moments = moments_of(recording)
    stated = recording.camera

    def load(index: int) -> Frame:
        frame = recording.load(index)
        return replace(frame, depth=corrected_image(sensor, frame.depth, stated, frame.ir, moments[index]))

    warnings = (*recording.warnings, *moments.warnings)
    better = replace(recording, camera=true_camera(sensor, stated), load=load, warnings=warnings)
    nothing = np.full(stated.shape, np.nan, np.float32)
    view = View(stated, nothing)
    for index in np.unique(np.linspace(0, len(recording) - 1, LOOKED_AT).round().astype(int)) if len(recording) else ():
        try:
            frame = recording.load(int(index))
        except RecordingError:
            continue
        if np.isfinite(frame.depth).any():
            view = View(stated, frame.depth, ir=frame.ir, moment=moments[int(index)])
            break
    return better, tell(sensor, view)
