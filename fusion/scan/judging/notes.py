"""What readers and the correction say of a scan, and what went missing on the way."""

import numpy as np

from fusion.geometry.trajectory import Trajectory
from fusion.recording.recording import Recording
from fusion.results.light import Light, note
from fusion.sensor.correction.summary import CorrectionSummary
from fusion.turntable.motion import Motion

GUESSED = 0.003  # of the radius: more is told (guess)
PLATE_TURNS = "not round: a slab that turns close above the table; it is cut off, --keep-plate keeps it"


def notes_of(recording: Recording, told: CorrectionSummary, motion: Motion, raw: Trajectory) -> list[Light]:
    """What readers and the correction say, and what went missing on the way."""
    notes = [note("Recording", "warning", text) for text in recording.warnings]
    notes += [note("Correction", "warning", text) for text in told.doubtful]
    if told.guessed > GUESSED * motion.radius:
        # surfaces at an angle are darker: what is wrong there moves the axis by as much
        text = f"brightness was guessed, and {told.guessed * 1e3:.1f} mm of depth with it: the size may be wrong by "
        notes.append(note("Correction", "warning", f"{text}{told.guessed / motion.radius:.1%}; record IR images too"))
    if motion.plate is None:
        notes.append(note("Plate", "warning", "no plate was seen: nothing was cut off below the object"))
    if motion.table is not None:
        notes.append(note("Plate", "ok", PLATE_TURNS))
    lost = int((np.isfinite(motion.angles) & ~raw.valid).sum())
    if lost:
        text = f"{lost} frames could not be tracked freely and stand by the axis alone"
        notes.append(note("Tracking", "warning", text))
    return notes
