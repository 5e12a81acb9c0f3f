"""`fusion turntable`: an object on a turntable becomes a mesh, with axis, angles and a closed loop."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fusion.commands.options.numbers import number
from fusion.commands.options.results import add_keep_failed, made
from fusion.commands.options.shown import add_common, shown_box, shown_name, shown_sensor
from fusion.commands.terminal.screen import took
from fusion.errors import TrackingError
from fusion.progress import seconds, stage
from fusion.quantity import REFLECTANCE, STEP

if TYPE_CHECKING:
    from fusion.recording.recording import Recording
    from fusion.report.scans.scan import ScanReport
    from fusion.scan.result import Scan
    from fusion.scan.settings import ScanSettings

FRAMES = """frames: mesh.ply and trajectory.txt stand in the object's frame: z up along the axis, plate at z = 0.
The axis in turntable.json and --box stand in the first camera's frame: x right, y down, z forward."""
EXAMPLE = "fusion turntable my_scan -o out --sensor kinect-v1"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add_common(parser)
    parser.epilog = f"{FRAMES}\n\n{parser.epilog}"
    add = parser.add_argument
    add("--mask", type=Path, metavar="PNG", help="nonzero on the object: one PNG, or a folder with one per depth frame")
    add(
        "--step",
        type=number(STEP),
        metavar="DEG",
        help="turn between frames [deg], when the recording has no log of it",
    )
    add("--ignore-log", action="store_true", help="do not use turntable_deg of telemetry.csv")
    add("--strength", choices=("axis", "circle"), default="axis", help="post-pass: one axis, or centres on a circle")
    camera = parser.add_mutually_exclusive_group()
    camera.add_argument(
        "--refine-camera",
        action="store_true",
        default=None,
        help="take out the error of the focal length that the scan shows, however small (default: one that it is sure "
        "of, where camera.json does not say how well the focal length is known)",
    )
    camera.add_argument(
        "--keep-camera", action="store_false", dest="refine_camera", help="leave the focal length as it is stated"
    )
    add_keep_failed(parser, "scan")
    add("--keep-plate", action="store_true", help="leave the turntable's plate in the mesh, cut round about the axis")
    add(
        "--plate-reflectance",
        type=number(REFLECTANCE),
        metavar="R",
        help="share of the light that the plate reflects (black 0.05, wood 0.5, white 0.8): takes out of a "
        "time-of-flight scan what that light does to the sides",
    )


def run(options: argparse.Namespace) -> None:
    """Scan and write the results."""
    from fusion.files.json_values import json_text
    from fusion.recording.open import open_recording
    from fusion.scan.pipeline import scan_turntable

    recording = open_recording(options.recording, options.camera, options.topic)
    scan = scan_turntable(recording, _settings(options, recording))
    failed = failure(scan, options.recording)
    if failed is not None and not options.keep_failed:
        raise failed
    with options.claim.folder() as partial:
        fill(partial, recording, scan, page=options.report)
    numbers = summary(scan) | {"seconds": seconds()}
    if options.json:
        print(json_text(numbers | {"output": str(options.output)}))
    else:
        zero = "plate at z = 0" if scan.motion.plate is not None else "no plate seen: z = 0 beside the object's middle"
        frame = f"frame     mesh.ply: z up, {zero}; turntable.json: the first camera's (x right, y down, z forward)"
        print("\n".join([*lines(scan), frame, *made(options, "report"), f"took      {took(numbers['seconds'])}"]))
    if failed is not None:
        raise failed


def failure(scan: "Scan", where: Path) -> TrackingError | None:
    """Why a scan is not handed out, in one line; None where it is good, or only doubtful."""
    worth = scan.judgement.worth
    if worth.word != "failed":
        return None
    worst = worth.reasons[0]
    log = scan.told is not None and scan.settings.step is None and worst.subject != "Log"
    suspect = "Or its log is wrong (turntable_deg in degrees?): --ignore-log does without. " if log else ""
    do = f"{worst.do} {suspect}--keep-failed writes what there is"
    return TrackingError("the scan failed", where, worst.reason.rstrip("."), do=do)


def _settings(options: argparse.Namespace, recording: "Recording") -> "ScanSettings":
    import numpy as np

    from fusion.scan.settings import ScanSettings

    return ScanSettings(
        sensor=shown_sensor(options, recording.camera),
        box=shown_box(options.box),
        mask=options.mask,
        step=None if options.step is None else float(np.deg2rad(options.step)),
        use_log=not options.ignore_log,
        strength=options.strength,
        refine_camera=options.refine_camera,
        keep_plate=options.keep_plate,
        plate_reflectance=options.plate_reflectance,
        voxel=options.voxel,
        truncation=options.truncation,
        color=not options.no_color,
        force=options.force,
    )


def fill(folder: Path, recording: "Recording", scan: "Scan", comparison: Any = None, page: bool = True) -> None:
    """All files of the command into a folder; report.html if `page`."""
    from fusion.files.json_values import json_text, json_values
    from fusion.mesh.files import write_mesh
    from fusion.recording.native.camera_file import write_camera
    from fusion.recording.native.trajectory_file import write_trajectory
    from fusion.report.scans.scan import scan_report

    write_mesh(folder / "mesh.ply", scan.mesh)
    write_trajectory(folder / "trajectory.txt", scan.trajectory)
    write_trajectory(folder / "trajectory_raw.txt", scan.trajectory_raw)
    (folder / "turntable.json").write_text(json_text(scan.turntable()) + "\n", encoding="utf-8")
    if scan.evidence.refined:
        write_camera(folder / "camera.json", scan.camera)
    if page:
        with stage("report"):
            scan_report(folder / "report.html", report(recording, scan, comparison))
    content = json_values(scan.settings) | {
        "recording": str(recording.path),
        "frames": len(recording),
        "result": scan.facts.values(),
        "agreement": scan.evidence.agreement.values(),
        "pulled": scan.evidence.pulled,
        "sigma": None if scan.sure is None else scan.sure.values(),
        "judgement": scan.judgement.lights,
        "warnings": scan.judgement.warnings,
        "footnotes": scan.judgement.footnotes,
        "seconds": seconds(),
    }
    (folder / "settings.json").write_text(json_text(content) + "\n", encoding="utf-8")


def report(recording: "Recording", scan: "Scan", comparison: Any = None) -> "ScanReport":
    """What the page shows."""
    from dataclasses import replace

    import numpy as np

    from fusion.files.json_values import json_values
    from fusion.geometry.trajectory import Trajectory
    from fusion.recording.looking.inspect import fingerprint
    from fusion.report.scans.scan import ScanReport
    from fusion.report.scans.seen import times_seen

    # coverage from at most 60 frames: more take long and say nothing new
    some = slice(None, None, max(1, len(recording) // 60))
    seen = Trajectory(scan.trajectory.timestamps[some], scan.trajectory.poses[some])
    return ScanReport(
        scan.mesh,
        facts=scan.facts,
        title=f"Turntable scan of {shown_name(recording.path)}",
        subtitle=f"{len(recording)} frames, {recording.format}",
        trajectory_raw=scan.trajectory_raw,
        trajectory=scan.trajectory,
        # everything on the page stands in the object's frame, whose z is the axis
        turntable=replace(scan.turntable(), axis_point=np.zeros(3), axis_direction=np.array([0.0, 0.0, 1.0])),
        residual=scan.residual,
        inlier_share=scan.inlier_share,
        rejected=scan.motion.rejected,
        times_seen=times_seen(scan.mesh, seen, scan.camera),
        mesh_raw=scan.mesh_raw,
        up=np.array([0.0, 0.0, 1.0]),
        settings=json_values(scan.settings),
        verdict=scan.judgement.worth.line(),
        summary=scan.judgement.lights,
        warnings=[("ok", text) for text in scan.judgement.footnotes],
        fingerprint=fingerprint(recording),
        command="fusion " + " ".join(sys.argv[1:]),
        comparison=comparison,
    )


def summary(scan: "Scan") -> dict[str, Any]:
    """The numbers that a caller wants first."""
    table = scan.turntable()
    return scan.facts.values() | {
        "verdict": table.verdict,
        "reasons": table.reasons,
        "rejected": table.rejected_reasons,
        "slips": table.slips,
        "correction": scan.settings.correction,
        "voxel_m": scan.settings.voxel_m,
        "uncolored_share": scan.settings.uncolored_share,
        "focal_length_check": table.focal_length_check,
        "judgement": scan.judgement.lights,
        "warnings": scan.judgement.warnings,
    }


def lines(scan: "Scan") -> list[str]:
    """The summary for a person."""
    from fusion.results.words import closing_words, hidden_words, mesh_words, sure_words, table_words
    from fusion.scan.judging.notes import PLATE_TURNS

    facts, table = scan.facts, scan.facts.table
    assert table is not None  # a turntable turned
    return [
        f"verdict   {scan.judgement.worth.line()}",
        *scan.judgement.lines(),
        f"frames    {facts.placed} of {facts.frames} placed",
        f"table     {table_words(table)}; {closing_words(table)}",
        *([f"plate     {PLATE_TURNS}"] if table.slab_cut else []),
        f"mesh      {mesh_words(facts.shape)}, voxel {scan.settings.voxel_m * 1e3:g} mm",
        *([f"foot      {hidden_words(table)}"] if table.hidden > 0 else []),
        *([] if facts.sure is None else [f"sigma     {sure_words(facts.sure)}"]),
        f"corrected {scan.settings.correction.text}",
    ]
