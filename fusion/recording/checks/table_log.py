"""Is the angle of the turntable logged in degrees?"""

import numpy as np

from fusion.recording.checks.stillness import turns_before_a_still_camera
from fusion.recording.looking.finding import Finding
from fusion.recording.looking.sample import Sample

TURNS = 3  # whole turns that are looked for
NEAR = 0.01  # share of a turn by which a log in radians may miss a whole number of them
SMALL = 20.0  # [deg] three turns in radians: an object that shows so little of itself is not put on a turntable
LEAST = 0.3  # below, the table stood


def check_table_log(sample: Sample) -> list[Finding]:
    """A log that turns so little, although something turns before the camera, or by 6.28, is one in radians."""
    recording = sample.recording
    logged = recording.telemetry_at_frames("turntable_deg")
    if logged is None or len(logged) < 3:
        return []
    total = float(np.ptp(logged))
    if not LEAST < total < SMALL:
        return []
    # the last frame of a turn may be one step before the first
    closed = np.array([total, total * len(logged) / (len(logged) - 1)])
    turns = closed[:, None] / (2 * np.pi * np.arange(1, TURNS + 1))
    whole = bool((np.abs(turns - 1) < NEAR).any())
    if not whole and not turns_before_a_still_camera(sample):
        return []
    seen = f"turntable_deg turns by {total:.3g} in all" + (", which is whole turns in radians" if whole else "")
    do = f"if these are radians ({np.rad2deg(total):.0f} deg), write degrees; turntable --ignore-log does without it"
    return [Finding("table", "warning", seen, do)]
