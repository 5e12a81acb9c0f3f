"""`fusion calibrate depth`: walls at known distances become a depth correction."""

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fusion.commands.options.numbers import number
from fusion.commands.options.results import add_output, add_topic, made
from fusion.files.json_values import json_text
from fusion.progress import stage
from fusion.quantity import DISTANCE_STD, RADIAL_LIMIT

if TYPE_CHECKING:
    from fusion.calibration.depth.calibration import DepthCalibration

EXAMPLE = "fusion calibrate depth wall_* --camera camera.json -o calibrated"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    add("recordings", type=Path, nargs="+", metavar="REC", help="a wall each, its distance_m in telemetry.csv if known")
    add_output(parser, "folder for sensor.json and report.html")
    add("--camera", metavar="C", help="calibrated camera.json, a preset's name or fx,fy,cx,cy")
    add_topic(parser)
    add("--sensor", metavar="S", help="sensor.json or a preset's name: what is already known")
    add(
        "--board",
        type=Path,
        metavar="JSON",
        help="board.json: each picture that shows the board is a wall, placed by its corners",
    )
    add(
        "--distance-std",
        type=number(DISTANCE_STD),
        default=0.001,
        metavar="M",
        help="standard deviation of distance_m [m]; 0.001",
    )
    add(
        "--radial-limit",
        type=number(RADIAL_LIMIT),
        metavar="PX",
        help="use no pixel farther than this from the principal point (Pagliari: 300)",
    )
    add("--no-map", action="store_true", help="leave out maps of what is left per pixel")
    add("--force", action="store_true", help="take recordings or models of another camera")
    add("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> None:
    """Calibrate and write sensor.json and report.html."""
    from fusion.calibration.depth.calibration import DepthSettings, calibrate_depth
    from fusion.calibration.lens.boards.board import read_board
    from fusion.recording.open import open_recording, stated_camera
    from fusion.sensor.files.sensor_file import read_sensor

    settings = DepthSettings(
        board=None if options.board is None else read_board(options.board),
        camera=stated_camera(options.camera, options.recordings[0], options.topic),
        sensor=None if options.sensor is None else read_sensor(options.sensor),
        distance_std=options.distance_std,
        surface=not options.no_map,
        force=options.force,
        radial_limit=options.radial_limit,
    )
    found = calibrate_depth([open_recording(path, topic=options.topic) for path in options.recordings], settings)
    told = {"distance_std_m": options.distance_std, "camera": options.camera or "recordings'"}
    told |= {"radial_limit_px": options.radial_limit or "none"}
    with options.claim.folder() as partial:
        fill(partial, found, told if options.report else None)
    numbers = summary(found)
    if options.json:
        print(json_text(numbers | {"output": str(options.output)}))
    else:
        print("\n".join([*_lines(numbers), *made(options, "sensor", "report")]))


def fill(folder: Path, found: "DepthCalibration", settings: Mapping[str, object] | None) -> None:
    """sensor.json with its maps, and report.html with the settings if any, into a folder."""
    from fusion.report.calibrations.depth_calibration import depth_report
    from fusion.sensor.files.sensor_file import write_sensor

    write_sensor(folder / "sensor.json", found.sensor)
    if settings is not None:
        with stage("report"):
            depth_report(folder / "report.html", found, "fusion " + " ".join(sys.argv[1:]), settings)


def summary(found: "DepthCalibration") -> dict[str, Any]:
    """The numbers that a caller wants first; lengths in metres."""
    walls = [
        {
            "recording": wall.name,
            "distance_m": _number(wall.distance),
            "error_m": _number(offset),
            "error_std_m": _number(deviation),
            "left_heldout_m": float(left),
            "tilt_rad": wall.plane.tilt,
            "share_of_image": float(wall.mask.mean()),
        }
        for wall, offset, deviation, left in zip(
            found.walls, found.offset, found.offset_std, found.best.rms, strict=True
        )
    ]
    curve = found.curve
    return {
        "law": found.best.candidate.name,
        "heldout_before_m": found.before.error,
        "heldout_after_m": found.best.error,
        "heldout_axis_m": _number(found.best.axis_error),
        "radial_limit_px": found.radial_limit,
        "walls": walls,
        "candidates": {j.candidate.name: j.error for j in found.judged},
        "curve": None
        if curve is None
        else {
            "distance_m": curve.distance.tolist(),
            "error_m": curve.bias.tolist(),
            "half_width_90_m": curve.half_width.tolist(),
        },
        "not_seen": sorted({f"{v.term.effect}.{v.term.parameter}" for v in found.visibility if not v.seen}),
        "notes": [text for _, text in found.notes],
    }


def _number(value: float) -> float | None:
    import math

    return float(value) if math.isfinite(value) else None


def _reach(limit: float | None) -> str:
    if limit is None:
        return "the border of what was recorded: no ring of the image is twice as bad as the others"
    return f"{limit:.0f} px from the principal point; beyond, the corrected depth is twice as bad (--radial-limit)"


def _lines(numbers: dict[str, Any]) -> list[str]:
    low, high = numbers["heldout_before_m"] * 1e3, numbers["heldout_after_m"] * 1e3
    glossy = " (what the board mirrors taken out too)" if "gloss" in numbers["law"] else ""
    held_out = f"{high:.2f} mm rms on a wall left out{glossy}, {low:.2f} mm without correction"
    return [
        f"law       {numbers['law']}, of {len(numbers['candidates'])} candidates",
        f"held out  {held_out if len(numbers['walls']) > 1 else 'one wall: nothing'}",
        f"good to   {_reach(numbers['radial_limit_px'])}",
        *(f"note      {text}" for text in numbers["notes"]),
    ]
