"""Frames that a camera's own even rate misses, and clocks that jump."""

import numpy as np
from numpy.typing import NDArray

from fusion.recording.finding import Finding
from fusion.recording.recording import Recording

SLOWEST = 5.0  # frames a second: below, a person or a program chose the moments
EVEN, MOST_UNEVEN = 0.2, 0.1  # a step is whole where it is this near to a multiple of the usual one; the rest at most
FEW = 0.02  # share of missing frames from which tracking may feel it (guess)
LEAST = 30  # frames that tell a rate
SIDE = 60  # frames on either side of a jump: a recorder may be held up for half of them
JUMP = 0.2  # [s] between two clocks: more than any queue of a recorder holds up (guess)


def missing_frames(stamps: NDArray[np.float64], longest: float) -> list[Finding]:
    """Frames that were dropped: steps of two, three, ... times the usual one, in a recording of an even rate.

    Args:
        stamps: (n,) [s] in order.
        longest: in usual steps: longer ones are gaps of another kind.
    """
    steps = np.diff(stamps)
    steps = steps[steps > 0]
    if len(steps) < LEAST:
        return []
    usual = float(np.median(steps))
    count = np.rint(steps / usual)
    whole = (np.abs(steps / usual - count) < EVEN) & (count > 0)
    if 1 / usual < SLOWEST or np.mean(~whole) > MOST_UNEVEN:
        return []
    lost = int((count[whole & (steps <= longest * usual)] - 1).sum())
    share = lost / (len(stamps) + lost)
    if not lost:
        return []
    seen = f"{lost} of {len(stamps) + lost} frames are missing, by an even rate of {1 / usual:.4g} a second"
    if share < FEW:
        return [Finding("stamps", "ok", seen)]
    do = "record to a faster disk, or with fewer or smaller streams"
    return [Finding("stamps", "warning", f"{seen} ({share:.0%})", do)]


def clock_jumps(recording: Recording) -> list[Finding]:
    """Where the device's clock jumps against the machine's that recorded it."""
    device, machine = _clocks(recording)
    if len(device) < LEAST:
        return []
    pace = np.median(np.diff(device)) / max(float(np.median(np.diff(machine))), 1e-9)
    if not 0.9 < pace < 1.1:  # played back faster, or written later: no second clock
        return []
    apart = device - machine
    side = min(SIDE, len(apart) // 3)
    middles = np.median(np.lib.stride_tricks.sliding_window_view(apart, side), axis=1)
    off = middles[side:] - middles[:-side]  # of frames from `side` on, behind and before
    first = int(np.abs(off).argmax())
    if abs(off[first]) < JUMP:
        return []
    around = np.abs(np.diff(apart[first : first + 2 * side]))
    at = first + int(around.argmax()) + 1
    seen = f"the device's clock jumps by {off[first]:+.2f} s against the recording machine's at frame {at}"
    do = "do not trust what is joined by time behind it (poses, colour, a table's log)"
    return [Finding("stamps", "warning", seen, do)]


def _clocks(recording: Recording) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(n,) [s] of the device and of the recording machine; empty where one is not known."""
    streams, logged = recording.streams, recording.telemetry
    if streams is not None and len(streams.arrivals) == len(recording):
        return recording.timestamps, streams.arrivals
    if "device_s" in logged and "host_s" in logged:
        known = np.isfinite(logged["device_s"]) & np.isfinite(logged["host_s"])
        return logged["device_s"][known], logged["host_s"][known]
    return np.zeros(0), np.zeros(0)
