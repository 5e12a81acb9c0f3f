"""Frames that a camera's own even rate misses, and clocks that jump."""

import numpy as np
from numpy.typing import NDArray

from fusion.recording.looking.finding import Finding
from fusion.recording.recording import Recording

SLOWEST = 5.0  # frames a second: below, a person or a program chose the moments
EVEN, MOST_UNEVEN = 0.2, 0.1  # a step is whole where it is this near to a multiple of the usual one; the rest at most
ROUND = (
    0.4  # of a frame: what steps of a clock that jitters by a twentieth lack to whole ones; a late frame leaves more
)
FEW = 0.02  # share of missing frames from which tracking may feel it (guess)
# steps that tell a rate. Chance steps of any kind (even, exponential, log-normal) look whole and lacking in less than
# 0.1 % of recordings this short, clocks that jitter by up to 0.3 steps as well (simulated, tests/recording/test_clocks)
LEAST = 8
# frames that tell a row of even moments, how far from it one counts as off (in steps), and how much of that the row
# follows. Chance steps lie in such a row in less than 0.1 % of recordings (simulated, tests/recording/test_clocks)
MANY, OFF_ROW, FOLLOWED = 40, 0.2, 0.2
TWO_CLOCKS = 30  # frames that tell how far two clocks are apart
SIDE = 60  # frames on either side of a jump: a recorder may be held up for half of them
JUMP = 0.2  # [s] between two clocks: more than any queue of a recorder holds up (guess)


def missing_frames(stamps: NDArray[np.float64], longest: float) -> list[Finding]:
    """Frames that were dropped: steps of two, three, ... times the usual one, in a recording of an even rate.

    A frame that came late, stamped by the recording machine, makes a long step too, and short ones behind it: only what
    these do not make good is missing. Behind the last step nothing could, so it is not counted.

    Args:
        stamps: (n,) [s] in order.
        longest: in usual steps: longer ones are gaps of another kind.
    """
    steps = np.diff(stamps)
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    if len(steps) < LEAST or not 0 < usual < 1 / SLOWEST:
        return []
    # a clock that jitters spoils steps, but its moments do not leave an even row
    places = _places(stamps, usual)
    share = steps / usual if places is None else np.diff(places)
    if np.mean(np.abs(share - np.rint(share)) >= EVEN) > MOST_UNEVEN:
        return []
    more = share[:-1] - 1
    lost = int(more[(np.abs(more) > 0.5) & (share[:-1] <= longest)].sum() + ROUND)
    if lost < 1:
        return []
    whole = len(stamps) + lost
    seen = f"{lost} of {whole} frames are missing, by an even rate of {1 / usual:.4g} a second"
    if lost < FEW * whole:
        return [Finding("stamps", "ok", seen)]
    do = "record to a faster disk, or with fewer or smaller streams"
    return [Finding("stamps", "warning", f"{seen} ({lost / whole:.0%})", do)]


def _places(stamps: NDArray[np.float64], usual: float) -> NDArray[np.float64] | None:
    """Places (n,) of frames in a row of even moments, whole numbers; None where they lie in none.

    `usual`: step [s] near that of the row.
    """
    if len(stamps) < MANY:
        return None
    places, _ = _followed(stamps, usual)
    if places[-1] < len(places) / 2:
        return None
    places, off = _followed(stamps, float(np.polyfit(places, stamps - stamps[0], 1)[0]))
    return None if np.mean(np.abs(off) >= OFF_ROW) > MOST_UNEVEN else places


def _followed(stamps: NDArray[np.float64], step: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Places (n,) in a row that is followed from frame to frame, and how far each lies off it [steps]."""
    counts, off = np.zeros(len(stamps)), np.zeros(len(stamps))
    moment = float(stamps[0])  # of the row
    for i, stamp in enumerate(stamps.tolist()[1:], start=1):
        steps = (stamp - moment) / step
        counts[i] = round(steps)
        off[i] = steps - counts[i]
        moment += step * (float(counts[i]) + FOLLOWED * float(off[i]))
    return np.cumsum(counts), off


def clock_jumps(recording: Recording) -> list[Finding]:
    """Where the device's clock jumps against the machine's that recorded it."""
    device, machine = _clocks(recording)
    if len(device) < TWO_CLOCKS:
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
