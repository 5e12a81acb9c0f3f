"""What a person should know about a scan."""

import numpy as np

from fusion.geometry.trajectory import Trajectory
from fusion.recording.recording import Recording
from fusion.sensor.sensor import Sensor
from fusion.sensor.told import Told
from fusion.turntable.motion import Motion
from fusion.turntable.steps import Steps

WRONG_FOCAL = 0.01  # relative error of the focal length that is worth a warning
SURE = 3.0  # standard deviations of it that are evidence


def focal_is_wrong(relative: float, std: float) -> bool:
    """True when an error of the focal length is both worth a warning and sure."""
    return abs(relative) > max(WRONG_FOCAL, SURE * std)


def warnings_of(
    recording: Recording, sensor: Sensor, told: Told, found: tuple[Motion, Steps, Trajectory]
) -> tuple[tuple[str, str], ...]:
    motion, steps, raw = found
    out = [("warning", text) for text in (*recording.warnings, *sensor.warnings, *steps.warnings)] + told.notes
    focal = float(np.expm1(motion.focal_check.values[0]))
    if focal_is_wrong(focal, motion.focal_std):
        stated, right = recording.camera.fx, recording.camera.fx * (1 + focal)
        why = f"the object keeps its shape only with fx {right:.1f} px instead of {stated:.1f} px ({focal:+.1%})"
        out.append(("bad", f"{why}; calibrate the camera or pass --refine-camera"))
    if motion.plate is None:
        out.append(("warning", "no plate was seen: nothing was cut off below the object"))
    lost = int((np.isfinite(motion.angles) & ~raw.valid).sum())
    if lost:
        out.append(("warning", f"{lost} frames could not be tracked freely and stand by the axis alone"))
    out += [("warning", f"frame {frame}: {reason}") for frame, reason in list(motion.rejected.items())[:10]]
    return tuple(out)
