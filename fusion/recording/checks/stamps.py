"""Are the time stamps in order, different, even, of one clock, and do the other images belong to depth frames?"""

import numpy as np

from fusion.recording.checks.clocks import clock_jumps, missing_frames
from fusion.recording.images.frame_files import ASSOCIATION_SECONDS
from fusion.recording.looking.finding import Finding
from fusion.recording.looking.sample import Sample
from fusion.recording.recording import Recording

# in medians: a pause this long is more than dropped frames
GAP = 10.0
UNITS = {"milliseconds": 1e3, "microseconds": 1e6, "nanoseconds": 1e9}
RATES, EVEN = (5.0, 6.0, 10.0, 15.0, 25.0, 30.0, 60.0, 90.0), 0.03  # of cameras, and how near one is met
LEAST = 5.0  # [s] no camera's rate; below it seconds are never doubted
SLOW = 0.1  # frames a second: below, what is between two of them says more
FEWEST = 5  # steps


def check_stamps(sample: Sample) -> list[Finding]:
    """Unsorted and equal stamps, gaps, missing frames, jumps of the clock, images without a depth frame."""
    recording = sample.recording
    stamps = recording.timestamps
    steps = np.diff(stamps)
    findings = _back(recording)
    equal = int((steps == 0).sum())
    if equal:
        do = "take the doubled lines out of depth.txt"
        findings.append(Finding("stamps", "warning", f"{equal} frames have the stamp of the one before", do))
    findings += unit_of_stamps(stamps)
    findings += _gaps(steps[steps > 0], stamps) + missing_frames(stamps, GAP) + clock_jumps(recording)
    findings += _unmatched(sample)
    rate = frames_per_second(stamps)
    if not findings:
        text = "in order" if rate is None else f"in order, {rate:.2f} frames a second"
        text = f"in order, {1 / rate:.3g} s from frame to frame" if rate is not None and rate < SLOW else text
        findings.append(Finding("stamps", "ok", text))
    return findings + _without_color(sample)


def _back(recording: Recording) -> list[Finding]:
    """Stamps that were, or are, not in the order in which the frames were stored."""
    files, backward = recording.files or recording.streams, -np.diff(recording.timestamps)
    if (backward > 0).any():
        at = int(backward.argmax()) + 1
        seen = (
            f"time stamps go back {int((backward > 0).sum())} times, the most by {backward.max():.3g} s at frame {at}"
        )
        return [
            Finding("stamps", "warning", seen, "do not trust what is joined by time (poses, colour, a table's log)")
        ]
    if files is None or not files.steps_back:
        return []
    if recording.files is not None:
        seen = f"stamps of the depth list go back {files.steps_back} times; the frames were sorted"
        return [Finding("stamps", "warning", seen, "sort depth.txt by its first column")]
    seen = f"time stamps go back {files.steps_back} times in the file; the frames were sorted"
    do = "where a clock was set back, frames of two moments are mixed now: use the part before or after it"
    return [Finding("stamps", "warning", seen, do)]


def unit_of_stamps(stamps: np.ndarray) -> list[Finding]:
    """Stamps (n,) that are no seconds: a camera's usual rate in another unit."""
    steps = np.diff(stamps)
    steps = steps[steps > 0]
    step = float(np.median(steps)) if len(steps) >= FEWEST else 0.0
    rates = {unit: count / step for unit, count in UNITS.items()} if step > LEAST else {}
    unit = next((u for u, rate in rates.items() if any(abs(rate / usual - 1) < EVEN for usual in RATES)), None)
    if unit is None:
        return []
    do = f"stamps are seconds; if these are {unit}, divide them by {UNITS[unit]:g}"
    return [Finding("stamps", "warning", f"{step:.4g} s from frame to frame", do)]


def frames_per_second(stamps: np.ndarray) -> float | None:
    """Frames a second, from the median step; None for fewer than two stamps."""
    steps = np.diff(stamps)
    steps = steps[steps > 0]
    return float(1 / np.median(steps)) if len(steps) else None


def _gaps(steps: np.ndarray, stamps: np.ndarray) -> list[Finding]:
    if len(steps) < 5:
        return []
    # a recording with pauses by plan has many of them: only a few among many even steps are gaps
    wide = np.flatnonzero(steps > GAP * np.median(steps))
    if not 0 < len(wide) <= max(1, len(steps) // 10):
        return []
    longest = wide[np.argmax(steps[wide])]
    at = stamps[longest] - stamps[0]
    seen = f"{len(wide)} gaps; the longest {steps[longest]:.3g} s at {at:.3f} s, usual step {np.median(steps):.3g} s"
    return [Finding("stamps", "warning", seen, "frames may be missing there; tracking may lose its way")]


def _unmatched(sample: Sample) -> list[Finding]:
    files = sample.recording.files or sample.recording.streams
    findings = []
    for name, (lost, total) in (files.unmatched if files else {}).items():
        # a camera that starts or stops a moment earlier loses a few
        severity = "warning" if lost > max(2, 0.1 * total) else "ok"
        if lost:
            seen = f"{lost} of {total} images of {name} have no depth frame within {ASSOCIATION_SECONDS:g} s"
            do = f"put the stamps of {name} on the clock of depth.txt" if severity == "warning" else ""
            findings.append(Finding("stamps", severity, seen, do))
    return findings


def _without_color(sample: Sample) -> list[Finding]:
    """Frames without a colour image, in a recording that has such images."""
    has = sample.recording.has_color
    if has is None or not has.any() or has.all():
        return []
    # no alarm: colour of another clock, or taken less often, is usual
    return [Finding("stamps", "ok", f"{int((~has).sum())} of {len(has)} frames have no colour image")]
