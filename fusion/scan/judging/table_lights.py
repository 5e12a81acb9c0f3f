"""What the table did, and whether object and camera stayed where they were."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.robust import SURE
from fusion.results.light import Light, level
from fusion.turntable.all_views.log import departure

if TYPE_CHECKING:
    from fusion.scan.result import Scan

Array = NDArray[np.float64]
# up to the first good, above the second a problem (guesses, for objects of some decimetres before a depth camera)
CLOSED = (3.0, SURE)  # times what other views miss each other by
WORSE = np.deg2rad(1.0)
JUMP_M = (0.0, 0.004)  # above the noise of free tracking: what a slip leaves
WOBBLE = (np.deg2rad(0.5), np.deg2rad(2.0))
UNLIKE = (0.03, 0.05)  # share of pairs or views; 0 to 0.02 where all views were right, more where some were not
SLIPS = "What was measured is used; fix the object to the plate, and look at the drive."
PULLED = (
    "Errors of depth that stand still in the image pull angles: calibrate camera and depth, and record two turns or "
    "more; or the log is wrong (--ignore-log)."
)
MIRRORED = (
    "If the table counts clockwise, all is well; else the images are mirrored, as some drivers give them (print on the "
    "object reads backwards), and so is the mesh: flip them."
)
MOVED = (
    "A part of what stands on the plate was moved while it turned, or the depth is wrong: fix it and record again, and "
    "calibrate camera and depth."
)
LATE = (
    "By print the object would move on its plate from view to view, by shape it does not: the colours seem to be of "
    "another moment than the depth, and had no say in the motion."
)
TOGETHER = "Record both together (fusion record), or turn in steps and wait; the colours on the mesh are blurred."
OFF_LOG = np.deg2rad(2.0)  # less is no harm that could be told from a table's own unevenness (guess)
LOG_RATIO = (0.03, 0.2)  # of all turns, as seen and as told


def table_lights(scan: "Scan") -> list[Light]:
    """Table, log, standing still, closing of the turn; those that say nothing are left out."""
    lights = [_table(scan), _log(scan), _print(scan), _standing(scan), _closing(scan)]
    return [light for light in lights if light is not None]


def _table(scan: "Scan") -> Light:
    steps, wobble = scan.steps, scan.wobble
    judged = level(wobble, WOBBLE) if np.isfinite(wobble) else "ok"
    said = "; ".join([f"{np.rad2deg(steps.mean):.2f} deg a frame", *steps.notes])
    if scan.motion.shifts is not None:
        moved = np.sqrt(np.nanmean(np.nansum((scan.motion.shifts - np.nanmean(scan.motion.shifts, 0)) ** 2, axis=1)))
        said += f"; turned by hand, which moved the object by {moved * 1e3:.0f} mm (rms): each frame has its own place"
    if scan.motion.marked:
        said += f"; {scan.motion.marked} frames are held by marks on what the object stands on, which turn with it"
    do = ""
    if judged != "ok":
        # freely tracked poses rock with the plate, and with a depth that is bent differently in each part of the image
        said += f"; its axis rocks by {np.rad2deg(wobble):.1f} deg (rms), or bent depth makes it look so"
        do = "Put the plate level and firm, and the object firmly on it; if they are, calibrate the depth."
    if steps.warnings:
        said += "; " + "; ".join(steps.warnings)
        judged, do = ("warning", SLIPS) if judged == "ok" else (judged, do)
    return Light(judged, "Table", said + ".", do)


def _log(scan: "Scan") -> Light | None:
    if scan.told is None:
        return None
    known = np.isfinite(scan.motion.angles)
    seen, told = float(np.ptp(scan.motion.angles[known])), float(np.ptp(scan.told[known]))
    judged = level(abs(np.log(max(seen, 1e-9) / max(told, 1e-9))), LOG_RATIO)
    said = f"The images turn by {np.rad2deg(seen):.0f} deg in all, as told: {np.rad2deg(told):.0f} deg."
    left, allowed = departure(scan.motion.angles, scan.told, [slip.frame for slip in scan.steps.slips])
    if judged == "ok" and scan.settings.step is None and _against(scan.motion.angles, scan.told):
        return Light("warning", "Log", f"{said} But they turn the other way than the log says.", MIRRORED)
    if judged == "ok" and left > max(allowed, OFF_LOG):
        said += f" In between they leave it smoothly by {np.rad2deg(left):.1f} deg"
        said += f", where steps as even as these could by {np.rad2deg(allowed):.1f} deg."
        return Light("warning", "Log", said, PULLED)
    if judged == "ok":
        return Light("ok", "Log", said)
    if 0.8 < seen / told / np.rad2deg(1) < 1.25:
        return Light(judged, "Log", said, "The log seems to be in radians: turntable_deg is read as degrees.")
    return Light(judged, "Log", said, "Check the unit of the log or --step, or leave it out with --ignore-log.")


def _against(angles: Array, told: Array) -> bool:
    """Whether angles (n,) [rad] run against a log, which counts right-handed about the axis that points up."""
    known = np.isfinite(angles) & np.isfinite(told)
    return bool(np.sum(np.diff(told[known]) * np.diff(angles[known])) < 0)


def _print(scan: "Scan") -> Light | None:
    """Whether views that were laid on each other show the same print: a box looks alike from both sides in shape."""
    if scan.motion.print_contradicts:
        return Light("warning", "Print", LATE, TOGETHER)
    found = scan.evidence.print
    if found is None or not np.isfinite(found.loose):
        return None
    against = 0.0 if np.isnan(found.against) else found.against
    loose = found.loose if scan.told is None else 0.0  # what was told holds views together too
    judged = level(max(against, loose), UNLIKE)
    if judged == "ok":
        return Light("ok", "Print", "What is printed on the object agrees from view to view.")
    differ = f"{against:.0%} of the pairs of views show other print where they were laid on each other"
    if scan.told is not None:
        source = "log" if scan.settings.step is None else "step"
        return Light(judged, "Print", f"{differ}.", f"What the {source} says of the turns may be wrong.")
    alone = f"{loose:.0%} of the views are not held together with the rest by print"
    said = " and ".join(text for text, share in ((differ, against), (alone, loose)) if share > UNLIKE[0])
    said += ": some may be turned to a side that looks alike in shape."
    return Light(judged, "Print", said, "Record in smaller steps, in even light, or give --step.")


def _standing(scan: "Scan") -> Light:
    jump = scan.evidence.jump
    if jump is None:
        return Light("ok", "Standing still", "Neither the object on its plate nor the camera was pushed.")
    said = f"The {jump.who} moved by {jump.distance * 1e3:.1f} mm before frame {jump.frame}"
    do = "Fix it, and record again; or give only the frames before or after."
    return Light(level(jump.distance, JUMP_M), "Standing still", f"{said}: the surface is doubled.", do)


def _closing(scan: "Scan") -> Light | None:
    gap, before = scan.closure, scan.closure_raw
    if gap is None:
        return None
    judged = level(gap.deviations, CLOSED)
    said = f"Where the turn closes, two views miss each other by {gap.distance * 1e3:.2f} mm"
    said += f" and {np.rad2deg(gap.angle):.2f} deg"
    if judged != "ok":
        said += f", {gap.deviations:.0f} times what other views of this scan do"
    if before is not None and gap.angle > max(before.angle, WORSE):
        said += f"; the angle got worse ({np.rad2deg(before.angle):.2f} deg before the post-pass)"
    return Light(judged, "Closing", said + ".", MOVED if judged != "ok" else "")
