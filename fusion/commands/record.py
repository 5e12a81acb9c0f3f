"""`fusion record`: from a camera, or from a recording played back, into a new recording."""

import argparse
import json
from dataclasses import asdict
from typing import TYPE_CHECKING

from fusion.commands.numbers import number, whole_number
from fusion.commands.results import add_output
from fusion.quantity import EVERY, RECORDED, SETTLE, STEP

if TYPE_CHECKING:
    from fusion.devices.record import Recorded
    from fusion.devices.source import Source

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
    table = "grbl:PORT[:AXIS] or a command, 'my_table --to {angle}' or '... --by {step}' [deg]"
    add("--table", metavar="TABLE", help=f"turn this table step by step, a frame of each place, one turn: {table}")
    add("--step", type=number(STEP), metavar="DEG", help="with --table: turn between frames, its sign (default: 10)")
    add("--settle", type=number(SETTLE), metavar="S", help="with --table: wait after each step (default: 0.5 s)")
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
    from fusion.errors import DeviceError

    options.recording = replayed(options.source)
    for name in ("step", "settle"):
        if getattr(options, name) is not None and options.table is None:
            raise DeviceError("there is no table to turn", f"--{name}", do="name it: --table grbl:PORT")


def run(options: argparse.Namespace) -> None:
    """Record until the source ends, the options say so, or Ctrl-C."""
    from fusion.devices.open import open_source
    from fusion.devices.record import RecordSettings, fill_recorded
    from fusion.recording.write import MEMBERS

    # with a table the source itself ends, after its places
    turn = options.turn and options.table is None
    settings = RecordSettings(options.frames, turn, options.every, options.color)
    with _before_a_table(open_source(options.source, options.camera, options.ir), options) as source:
        done = fill_recorded(source, options.output, lambda: options.claim.folder(MEMBERS), settings)
    ended = ROUND if options.table is not None and done.ended == "source" else ENDED[done.ended]
    if options.json:
        print(json.dumps(asdict(done) | {"path": str(done.path), "ended": ended}, indent=1))
    else:
        print(_line(done, ended))


def _before_a_table(source: "Source", options: argparse.Namespace) -> "Source":
    """The source, of one frame a place where there is a table."""
    if options.table is None:
        return source
    from fusion.devices.table.stepped import Stepped, open_table

    try:
        table = open_table(options.table)
    except BaseException:
        source.stop()
        raise
    given = {name: value for name in ("step", "settle") if (value := getattr(options, name)) is not None}
    count = None if options.frames is None else options.frames * options.every
    return Stepped(source, table, count=count, **given)


def _line(done: "Recorded", ended: str) -> str:
    rate = f", {(done.frames - 1) / done.seconds:.1f} a second" if done.seconds > 0 else ""
    lost = f"{done.missed} lost" if done.missed else "none lost"
    return (
        f"{done.path}: {done.frames} frames in {done.seconds:.1f} s{rate}, {lost}; {ended}; "
        f"{done.fullest} of {done.room} waited at most"
    )
