"""What a scan knows of its own faults, as lights for terminal, page and JSON."""

from typing import TYPE_CHECKING

import numpy as np

from fusion.geometry import pose
from fusion.mesh.shape import CRUMB
from fusion.results.judgement import Judgement
from fusion.results.light import AGAINST, LEVELS, Light, frames_light, level, worst_first
from fusion.scan.judging.camera_light import camera_light, size_light
from fusion.scan.judging.table_lights import table_lights

if TYPE_CHECKING:
    from fusion.scan.result import Scan

# up to the first good, above the second a problem (guesses, for objects of some decimetres before a depth camera)
NOISES = (2.0, 4.0)  # residual over what noise and voxel let expect
SMALL = 0.001  # [m] a residual below is good whatever was expected: a count of most files
DEPTH_M = (0.001, 0.004)  # what depth cameras reach where an object fills the image
GAP_DEG = (45.0, 120.0)
OPEN_SHARE = (0.05, 0.2)
DROPPED_SHARE = (0.05, 0.25)
# of the noise of a pixel, what patches of frames lie off the surface by: up to 0.34 in 54 good scans and a real
# box, 0.41 and more where an object was exchanged or tipped over (tools/sets/hard_scans, calibration, seed 1)
BENT = (0.35, 0.4)
LOST = (0.05, 0.15)  # share of the frames without a place: up to 0.10 in good ones of the same, 0.20 in one said good
STILL = 30.0  # [deg] views that all lie within this and contradict each other are of nothing that turns: guess
# of its width, how thick a slab is taken for a plate without a word: boards, books and discs are thinner (guess)
PLATE_THICK = 1 / 6
SURELY = 3.0  # standard deviations of the mean step, below which views go to and fro and nowhere
THIN_SHARE = 0.03  # of 13 scans without thin parts up to 0.015 had such, with them 0.07 (tools/sets/spoiled)
# of what noise leaves of the surface, what the poses bend it by: up to 0.15 where scans were good, 0.43 and more where
# they were not (tools/sets/hard_scans, seeds 404 and 405)
PULLED = (0.2, 0.3)
UNFIT = (0.05, 0.2)  # share of pairs of views that do not fit: 0 of the same good scans, 0.5 of a box turned over
WRONG = 0.2  # share of contradicting pixels from which the surface is not that of the object


def judge(scan: "Scan") -> Judgement:
    """All lights of a scan, the worst first."""
    lights = [
        camera_light(scan),
        *size_light(scan),
        _depth(scan),
        *table_lights(scan),
        frames_light(len(scan.motion.angles), scan.motion.rejected, LOST),
        _fit(scan),
        _agreement(scan),
        *_poses(scan),
        _coverage(scan),
    ]
    lights += [_surface(scan), *_thin(scan), *_stood_on(scan), *scan.evidence.notes]
    return Judgement(worst_first(lights), scan.evidence.footnotes)


def _fit(scan: "Scan") -> Light:
    known = scan.residual[np.isfinite(scan.residual)]
    if not len(known):
        return Light("bad", "Fit", "No frame could be placed on the model by its own surface.", "Check the recording.")
    found = float(np.median(known))
    expected = _expected(scan)
    judged = "ok" if found < SMALL else level(found / expected, NOISES)
    said = f"Frames lie {found * 1e3:.2f} mm (median) off the model, where {expected * 1e3:.2f} mm are expected."
    do = "Calibrate the depth (fusion calibrate depth), and check that the object is rigid." if judged != "ok" else ""
    return Light(judged, "Fit", said, do)


def _expected(scan: "Scan") -> float:
    """By how much a pixel may lie off the surface [m]."""
    return float(np.hypot(scan.evidence.noise, scan.settings.voxel_m / 2))


def _agreement(scan: "Scan") -> Light:
    """What single frames see against the surface that all of them made."""
    found = scan.evidence.agreement
    bent = found.bent / _expected(scan)
    contradicted = level(found.against, AGAINST)
    judged = max(contradicted, level(bent, BENT) if np.isfinite(bent) else "ok", key=LEVELS.index)
    if judged == "ok":
        return Light("ok", "Agreement", "Single frames see the surface where it is.")
    if contradicted == "ok":
        said = f"Patches of single frames, over which noise averages out, lie {found.bent * 1e3:.2f} mm (rms) off the "
        said += f"surface that all of them made (noise of a pixel: {_expected(scan) * 1e3:.2f} mm)"
        do = "The object was moved or bends, or the depth is wrong: fix it to the plate, and record in even light; and "
        do += "calibrate the depth (fusion calibrate depth)."
    else:
        before, through, missing = (float(np.mean(x)) for x in (found.before, found.through, found.missing))
        said = f"Single frames contradict the surface in {found.against:.0%} of what they show (median): they see "
        said += f"something before it ({before:.0%}), look through it ({through:.0%}), or show what it lacks "
        said += f"({missing:.0%})"
        do = "Look for surfaces that are doubled: give --step or --box where the turns or the object were not found, "
        do += "and record in steps below 20 degrees with nothing else moving."
    if (span := 360 - _gap(scan)) < STILL:
        do = f"Nothing turns: all views lie within {span:.0f} deg. fusion reconstruct follows a camera that moves, and "
        do += "with --box a thing that a hand moves."
    return Light(judged, "Agreement", f"{said}.", do, fails=not found.against < WRONG)


def _poses(scan: "Scan") -> list[Light]:
    """What pairs of views say of the poses; silent where there are none."""
    found, sure = scan.evidence.pulled, scan.sure
    if found is None or sure is None:
        return []
    judged = max(level(found.surface / max(sure.own, 1e-9), PULLED), level(found.unfit, UNFIT), key=LEVELS.index)
    if judged == "ok":
        return [Light("ok", "Poses", "Pairs of views lie on each other where the motion puts them.")]
    said = f"By pairs of views the poses bend the surface by {found.surface * 1e3:.2f} mm (rms), where noise leaves "
    said += f"{sure.own * 1e3:.2f} mm"
    if found.unfit > UNFIT[0]:
        said += f"; {found.unfit:.0%} of the pairs that should show the same surface do not fit each other"
    do = "Fix the object to the plate, and record in smaller steps, or give --step."
    return [Light(judged, "Poses", f"{said}.", do)]


def _depth(scan: "Scan") -> Light:
    """Errors of depth that bend the object, which the motion was found without; a constant one shows in no scan."""
    T_camera_object = pose.inverse(scan.trajectory.poses[scan.trajectory.valid][0])
    points = scan.mesh.vertices[:: max(1, len(scan.mesh.vertices) // 5000)]
    size = float(np.std(scan.motion.camera_check.depth_change(pose.transform(T_camera_object, points))))
    judged = level(size, DEPTH_M)
    if judged == "ok":
        return Light("ok", "Depth", "No error of depth that bends the object was found.")
    said = f"The depth is wrong by about {size * 1e3:.1f} mm, here more and there less: the object bends as it turns."
    if scan.motion.taken_out.wrong_depth:
        said += " As far as that shows, it was taken out."
        return Light(judged, "Depth", said, "Calibrate the depth with boards too (fusion calibrate depth --board).")
    return Light(judged, "Depth", said, "Calibrate it (fusion calibrate depth), pass the result with --sensor.")


def _gap(scan: "Scan") -> float:
    """The largest angle between neighbouring views [deg]."""
    around = np.sort(scan.motion.angles[np.isfinite(scan.motion.angles)] % (2 * np.pi))
    return float(np.degrees(np.diff(np.append(around, around[0] + 2 * np.pi)).max()))


def _aimless(scan: "Scan") -> bool:
    """Whether the steps between views are no more in one direction than by chance."""
    steps = np.diff(scan.motion.angles[np.isfinite(scan.motion.angles)])
    return bool(abs(np.mean(steps)) * np.sqrt(len(steps)) < SURELY * np.std(steps))


def _coverage(scan: "Scan") -> Light:
    gap = _gap(scan)
    judged = level(gap, GAP_DEG)
    said = f"The largest gap between neighbouring views is {gap:.0f} deg."
    do = "Record a full turn, in steps of 5 to 20 degrees." if judged != "ok" else ""
    if judged == "bad" and scan.told is None and _aimless(scan):
        said += " They go to and fro: the object stood still, or looks alike from all sides."
        do = "Give --step or a log of the turns, or put marks on it."
    return Light(judged, "Coverage", said, do)


def _thin(scan: "Scan") -> list[Light]:
    """Parts as thin as the truncation; silent where there are none."""
    share = scan.evidence.thin_share
    if share < THIN_SHARE:
        return []
    said = f"{share:.0%} of the surface has another one within {scan.settings.truncation_m * 1e3:.0f} mm behind it:"
    said += " parts as thin come out thicker, and thinner ones are lost; or the surface is doubled."
    return [Light("warning", "Thin parts", said, "Scan them from nearer, with a finer --voxel and --truncation.")]


def _stood_on(scan: "Scan") -> list[Light]:
    """What may be no part of the object where no plate was seen, or part of it where a thick one was."""
    if scan.motion.plate_thickness > PLATE_THICK and not scan.settings.keep_plate:
        assert scan.motion.table is not None
        said = f"What turns up to {-1e3 * scan.motion.table:.0f} mm above the table was taken for a plate and cut off,"
        thickness = f"{scan.motion.plate_thickness:.0%}"
        said += f" though it may be {thickness} as thick as it is wide: a box, or the object's foot."
        return [Light("bad", "Plate", said, "If it is the object's, pass --keep-plate; else all is well.")]
    shape = scan.facts.shape
    beside = 1 - shape.largest_share - shape.crumb_share
    if scan.motion.plate is not None or scan.settings.keep_plate or beside < CRUMB:
        return []
    said = f"{beside:.0%} of the surface hangs together with none of the rest, and no plate was seen that would have"
    said += " been cut off: what the object stands on is in the mesh, or a thing beside it."
    return [Light("bad", "Plate", said, "Cut it off the mesh, or scan again with --box around the object alone.")]


def _surface(scan: "Scan") -> Light:
    shape, dropped = scan.facts.shape, 1 - scan.evidence.kept_share
    worse = max(level(shape.open_share, OPEN_SHARE), level(dropped, DROPPED_SHARE), key=LEVELS.index)
    said = f"The surface is {'closed' if shape.openings() == 'closed' else 'open: ' + shape.openings()}"
    said += f"; {shape.open_share:.0%} of it is missing" if worse != "ok" and shape.open_share > OPEN_SHARE[0] else ""
    said += f"; {dropped:.0%} lay in small loose pieces and was dropped" if dropped > DROPPED_SHARE[0] else ""
    do = "Black, shiny and hidden parts give no depth: dull them, or scan again from another height."
    return Light(worse, "Surface", said + ".", do if worse != "ok" else "")
