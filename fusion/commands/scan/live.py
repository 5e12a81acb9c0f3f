"""`fusion live`: an object on a turntable is recorded, seen growing, and becomes a result when it is done."""

import argparse
import importlib.util
from typing import TYPE_CHECKING

from fusion.commands.options.numbers import number, whole_number
from fusion.commands.options.results import add_keep_failed, add_output, made
from fusion.commands.options.shown import shown_sensor
from fusion.commands.options.turned_table import add_table, before_table, check_table, watches_turn
from fusion.commands.scan import turntable
from fusion.commands.terminal.screen import took
from fusion.files.json_values import json_text
from fusion.progress import note, seconds
from fusion.quantity import PORT, RECORDED, VOXEL

if TYPE_CHECKING:
    from fusion.live.session import Shown

EXAMPLE = "fusion live kinect-v1 -o out"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    add("source", metavar="SOURCE", help="as `fusion record` takes it: kinect-v1, realsense, replay:REC[@SPEED], ...")
    add_output(parser, "folder for mesh.ply, trajectory.txt, ...; the recording is written beside it, as OUT_recording")
    add("--port", type=whole_number(PORT), default=8080, metavar="N", help="of the page, on this machine alone (8080)")
    add("--no-view", action="store_true", help="no page, only a line of text")
    add("--frames", type=whole_number(RECORDED), metavar="N", help="end after N frames (default: at finish or Ctrl-C)")
    add("--turn", action="store_true", help="end when the table has turned once")
    add_table(parser)
    add("--sensor", metavar="S", help="sensor.json or a preset's name: corrects the depth and weighs it")
    add("--camera", metavar="C", help="camera.json, a preset's name or fx,fy,cx,cy, instead of the source's own")
    add("--voxel", type=number(VOXEL), metavar="M", help="edge of a voxel of the result [m]")
    add_keep_failed(parser, "scan")
    add("--json", action="store_true", help="print one JSON object")
    parser.epilog = f"ends with Ctrl-C or by the page; then as `fusion turntable OUT_recording`\n\n{parser.epilog}"


def check(options: argparse.Namespace) -> None:
    """Which files are read, so that none of them is written to; and that nothing is asked of a table that is none."""
    from fusion.devices.open import replayed

    options.recording = replayed(options.source)
    check_table(options)


def run(options: argparse.Namespace) -> None:
    """Record and show; then scan what was recorded, as `fusion turntable` does."""
    from fusion.devices.open import open_source
    from fusion.devices.record import RecordSettings
    from fusion.files.output.claim import claimed
    from fusion.live.session import record_live
    from fusion.recording.open import open_recording
    from fusion.recording.writing.write import MEMBERS
    from fusion.scan.pipeline import scan_turntable
    from fusion.scan.settings import ScanSettings

    beside = options.output.with_name(f"{options.output.name}_recording")
    read = [] if options.recording is None else [options.recording]
    with claimed(beside, "live", read, options.overwrite) as claim:
        shown = _shown(options)
        settings = RecordSettings(options.frames, watches_turn(options))
        with before_table(open_source(options.source, options.camera), options, options.frames) as source:
            done, watch = record_live(source, beside, lambda: claim.folder((*MEMBERS, "undone.txt")), settings, shown)
    recording = open_recording(beside)
    scan = scan_turntable(recording, ScanSettings(sensor=shown_sensor(options, recording.camera), voxel=options.voxel))
    failed = turntable.failure(scan, beside)
    if failed is not None and not options.keep_failed:
        raise failed
    with options.claim.folder() as partial:
        turntable.fill(partial, recording, scan, page=options.report)
    view = {"placed": watch.tracked, "lost": watch.untracked, "late": watch.feed.dropped}
    told = {"recording": str(beside), "recorded": done.frames, "missed": done.missed, "view": view}
    numbers = turntable.summary(scan) | told | {"seconds": seconds()}
    if options.json:
        print(json_text(numbers | {"output": str(options.output)}))
    else:
        line = f"recorded  {done.frames} frames in {beside}, {done.missed} lost; {view['placed']} in the view"
        print("\n".join([line, *turntable.lines(scan), *made(options, "report"), f"took      {took(seconds())}"]))
    if failed is not None:
        raise failed


def _shown(options: argparse.Namespace) -> "Shown | None":
    """The page, or None where it is not wanted; where viser is not installed, a line that says what would help."""
    if options.no_view:
        return None
    if importlib.util.find_spec("viser") is None:
        note('no page: viser is not installed (pip install "fusion-scan[live]"); this line of text is the view')
        return None
    from functools import partial

    from fusion.live.page import page

    note(f"the page: http://127.0.0.1:{options.port}")
    return partial(page, options.port)
