"""`fusion reconstruct`: correct, track, integrate; a recording becomes a mesh."""

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fusion.commands.options.numbers import number, whole_number
from fusion.commands.options.posed import add_pose_convention, stated_poses
from fusion.commands.options.results import made
from fusion.commands.options.shown import FIRST_CAMERA, add_common, shown_box, shown_name, shown_sensor
from fusion.commands.terminal.screen import took
from fusion.files.json_values import json_text, json_values
from fusion.progress import seconds, stage
from fusion.quantity import MAX_DEPTH, MEMORY, WORKERS

if TYPE_CHECKING:
    from fusion.reconstruction.large import Large
    from fusion.reconstruction.result import Reconstruction
    from fusion.reconstruction.settings import ReconstructSettings
    from fusion.recording.recording import Recording
    from fusion.tiles.fusing import Way

EXAMPLE = "fusion reconstruct my_scan -o out --sensor kinect-v1"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add_common(parser, f"the world, which is {FIRST_CAMERA} unless --poses say another")
    add = parser.add_argument
    add("--poses", metavar="FILE", help="TUM trajectory to use instead of tracking; `stated`: the recording's own")
    add_pose_convention(parser)
    add("--max-depth", type=number(MAX_DEPTH), metavar="M", help="leave out what is farther [m]")
    large = "for what does not fit: take about so much memory [GB], fuse space tile by tile; mesh.ply without colours"
    add("--memory", type=number(MEMORY), metavar="GB", help=large)
    add(
        "--workers",
        type=whole_number(WORKERS),
        metavar="N",
        help="with --memory: processes that fuse tiles (default 1)",
    )
    add("--scheduler", metavar="ADDRESS", help="with --memory: a running Dask scheduler, whose workers fuse the tiles")
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument("--room", action="store_true", default=None, help="it is a room: voxels of 5 to 20 mm")
    kind.add_argument("--object", action="store_false", dest="room", help="it is an object: voxels of 1 to 2 mm")


def run(options: argparse.Namespace) -> None:
    """Reconstruct and write the results."""
    from fusion.errors import FusionError
    from fusion.reconstruction.large import reconstruct_large
    from fusion.reconstruction.pipeline import reconstruct
    from fusion.recording.open import open_recording

    if options.memory is None and (options.workers or options.scheduler):
        do = "pass --memory GB too, or leave them out"
        raise FusionError("nothing to share between workers", "--workers, --scheduler", "no --memory", do=do)
    recording = open_recording(options.recording, options.camera, options.topic)
    large: Large | None = None
    with options.claim.folder() as partial:
        if options.memory is None:
            result = reconstruct(recording, _settings(options, recording))
        else:
            with _way(options) as way:
                settings, memory = _settings(options, recording), int(options.memory * 1e9)
                large = reconstruct_large(recording, settings, memory, partial / "mesh.ply", way)
            result = large.overview
        fill(partial, recording, result, page=options.report, large=large)
    numbers = summary(result) | _large(large) | {"seconds": seconds()}
    if options.json:
        print(json_text(numbers | {"output": str(options.output)}))
        return
    print(
        "\n".join(
            [*_lines(result), *_large_lines(large), *made(options, "report"), f"took      {took(numbers['seconds'])}"]
        )
    )


@contextmanager
def _way(options: argparse.Namespace) -> Iterator["Way"]:
    """How tiles are fused: here, or by workers while the block runs."""
    from fusion.tiles.fusing import one_by_one

    if options.scheduler is None and (options.workers or 1) == 1:
        yield one_by_one
        return
    from fusion.batch.cluster import client_of
    from fusion.tiles.spread import spread

    with client_of(options.workers or 1, options.scheduler, "--workers") as client:
        yield spread(client)


def _settings(options: argparse.Namespace, recording: "Recording") -> "ReconstructSettings":
    from fusion.reconstruction.settings import ReconstructSettings

    return ReconstructSettings(
        sensor=shown_sensor(options, recording.camera),
        poses=stated_poses(options.poses, options.pose_convention, recording),
        voxel=options.voxel,
        truncation=options.truncation,
        room=options.room,
        max_depth=options.max_depth,
        box=shown_box(options.box),
        color=not options.no_color,
        force=options.force,
    )


def fill(
    folder: Path, recording: "Recording", result: "Reconstruction", page: bool = True, large: "Large | None" = None
) -> None:
    """mesh.ply, trajectory.txt, settings.json and, if `page`, report.html, into a folder.

    Of a `large` one mesh.ply is there already, and the mesh of its overview becomes overview.ply.
    """
    from fusion.mesh.files import write_mesh
    from fusion.recording.native.trajectory_file import write_trajectory
    from fusion.report.scans.scan import scan_report

    write_mesh(folder / ("mesh.ply" if large is None else "overview.ply"), result.mesh)
    write_trajectory(folder / "trajectory.txt", result.trajectory)
    if page:
        with stage("report"):
            scan_report(folder / "report.html", _report(recording, result))
    content = json_values(result.settings) | {
        "recording": str(recording.path),
        "frames": len(recording),
        "result": result.facts.values(),
        "rejected": {str(frame): reason for frame, reason in result.rejected.items()},
        "sigma": None if result.sure is None else result.sure.values(),
        **_large(large),
        "judgement": result.judgement.lights,
        "warnings": result.judgement.warnings,
        "footnotes": result.judgement.footnotes,
        "seconds": seconds(),
    }
    (folder / "settings.json").write_text(json_text(content) + "\n", encoding="utf-8")


def _report(recording: "Recording", result: "Reconstruction") -> Any:
    import numpy as np

    from fusion.geometry.trajectory import Trajectory
    from fusion.recording.looking.inspect import fingerprint
    from fusion.report.scans.scan import ScanReport
    from fusion.report.scans.seen import times_seen

    # coverage from about 30 frames, each standing for those up to the next: more take long and say nothing new
    step = max(1, len(recording) // 30)
    some = slice(None, None, step)
    seen = Trajectory(result.trajectory.timestamps[some], result.trajectory.poses[some])
    tracked = np.isfinite(result.residual).any()
    return ScanReport(
        result.mesh,
        facts=result.facts,
        title=f"Reconstruction of {shown_name(recording.path)}",
        subtitle=f"{len(recording)} frames, {recording.format}",
        trajectory=result.trajectory,
        residual=result.residual if tracked else None,
        inlier_share=result.inlier_share if tracked else None,
        rejected=result.rejected,
        times_seen=step * times_seen(result.mesh, seen, recording.camera),
        settings=json_values(result.settings),
        summary=result.judgement.lights,
        warnings=[("ok", text) for text in result.judgement.footnotes],
        fingerprint=fingerprint(recording),
        command="fusion " + " ".join(sys.argv[1:]),
    )


def summary(result: "Reconstruction") -> dict[str, Any]:
    """The numbers that a caller wants first."""
    return result.facts.values() | {
        "rejected": {str(frame): reason for frame, reason in result.rejected.items()},
        "correction": result.settings.correction,
        "voxel_m": result.settings.voxel_m,
        "uncolored_share": result.settings.uncolored_share,
        "truncation_m": result.settings.truncation_m,
        "kind": result.settings.kind,
        "kind_reason": result.settings.kind_reason,
        "judgement": result.judgement.lights,
        "warnings": result.judgement.warnings,
    }


def _large(large: "Large | None") -> dict[str, dict[str, float]]:
    """What is told of a mesh made tile by tile."""
    if large is None:
        return {}
    told = {"voxel_m": large.voxel, "truncation_m": large.truncation, "pieces": large.tiles}
    return {"tiles": told | asdict(large.mesh)}


def _large_lines(large: "Large | None") -> list[str]:
    if large is None:
        return []
    mesh, (parts, crumbs) = large.mesh, large.mesh.parts
    said = f"{mesh.vertices:,} vertices, {mesh.faces:,} triangles, {mesh.area:.1f} m^2 in {parts:,} parts"
    return [
        f"tiles     {large.tiles}: {said}, voxel {large.voxel * 1e3:g} mm; {crumbs:,} crumbs left out",
        "overview  the lines above but this one are of overview.ply, in larger voxels",
    ]


def _kind(result: "Reconstruction") -> str:
    """What it was taken for, and why."""
    told = result.settings
    other = "--object for voxels of 1 to 2 mm" if told.room else "--room for voxels of 5 mm and more"
    hint = "" if told.kind_reason == "as told" else f"; pass {other}"
    return f"{told.kind:<9} {told.kind_reason}{hint}"


def _lines(result: "Reconstruction") -> list[str]:
    from fusion.results.words import mesh_words, sure_words

    facts = result.facts
    rms = facts.residual
    unaligned = "poses as given" if result.settings.poses == "given" else "nothing to align, one frame"
    sure = "" if facts.sure is None else f"; sigma {sure_words(facts.sure)}"
    first = next(iter(result.rejected.items()), None)
    reason = "" if first is None else f"; frame {first[0]}: {first[1]}"
    return [
        *result.judgement.lines(),
        f"frames    {facts.placed} of {facts.frames} placed{reason}",
        "residual  " + (unaligned if rms is None else f"{rms * 1e3:.2f} mm rms to the model") + sure,
        *([] if facts.off_course is None else [f"error     {facts.off_course.words()}"]),
        _kind(result),
        f"mesh      {mesh_words(facts.shape)}, voxel {result.settings.voxel_m * 1e3:g} mm",
        f"corrected {result.settings.correction.text}",
    ]
