"""`fusion record`: from a camera, or from a recording played back, into a new recording."""

import argparse
from dataclasses import asdict
from typing import TYPE_CHECKING

from fusion.commands.options.numbers import whole_number
from fusion.commands.options.results import add_output
from fusion.commands.options.turned_table import add_table, before_table, check_table, watches_turn
from fusion.files.json_values import json_text
from fusion.quantity import EVERY, RECORDED

if TYPE_CHECKING:
    from fusion.devices.record import Recorded

ROUND = "the table has turned once"
ENDED = {
    "frames": "as many frames as asked for",
    "turn": "one turn was seen",
    "stopped": "stopped by hand",
    "source": "the source ended",
}
EXAMPLE = "fusion record replay:my_scan -o again --turn"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    played = "replay:REC (any recording at its own rate; REC@4 four times faster, REC@max as fast as can be)"
    sources = f"kinect-v1[:SERIAL]; realsense[:SERIAL]; orbbec[:SERIAL] (untried); {played}"
    add("source", metavar="SOURCE", help=sources)
    add_output(parser, "folder of the new recording; whole from its first frame on, whatever ends it", report=False)
    add("--frames", type=whole_number(RECORDED), metavar="N", help="end after N frames (default: at Ctrl-C)")
    add("--turn", action="store_true", help="end when the table has turned once")
    add_table(parser)
    add("--every", type=whole_number(EVERY), default=1, metavar="N", help="record one frame of N (default: every one)")
    add("--ir", action="store_true", help="infrared instead of colours, from a camera that sends one at a time")
    add("--camera", metavar="FILE", help="camera.json, a preset's name or fx,fy,cx,cy, instead of the source's own")
    add(
        "--color",
        choices=("png", "jpeg"),
        default="png",
        help="png keeps every value; jpeg takes a tenth of the time and of the room (default: png)",
    )
    add("--json", action="store_true", help="print one JSON object")


def check(options: argparse.Namespace) -> None:
    """Which files are read, so that none of them is written to; and that nothing is asked of a table that is none."""
    from fusion.devices.open import replayed

    options.recording = replayed(options.source)
    check_table(options)


def run(options: argparse.Namespace) -> None:
    """Record until the source ends, the options say so, or Ctrl-C."""
    from fusion.devices.open import open_source
    from fusion.devices.record import RecordSettings, fill_recorded
    from fusion.recording.writing.write import MEMBERS

    settings = RecordSettings(options.frames, watches_turn(options), options.every, options.color)
    places = None if options.frames is None else options.frames * options.every
    with before_table(open_source(options.source, options.camera, options.ir), options, places) as source:
        done = fill_recorded(source, options.output, lambda: options.claim.folder(MEMBERS), settings)
    ended = ROUND if options.table is not None and done.ended == "source" else ENDED[done.ended]
    if options.json:
        print(json_text(asdict(done) | {"path": str(done.path), "ended": ended}))
    else:
        print(_line(done, ended))


def _line(done: "Recorded", ended: str) -> str:
    rate = f", {(done.frames - 1) / done.seconds:.1f} a second" if done.seconds > 0 else ""
    lost = f"{done.missed} lost" if done.missed else "none lost"
    return (
        f"{done.path}: {done.frames} frames in {done.seconds:.1f} s{rate}, {lost}; {ended}; "
        f"{done.fullest} of {done.room} waited at most"
    )
