"""`fusion calibrate depth`: walls at known distances become a depth correction."""

import argparse
import math
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from fusion.commands.options.numbers import number
from fusion.commands.options.results import add_output, add_topic, made
from fusion.files.json_values import json_text, json_values
from fusion.progress import stage
from fusion.quantity import DISTANCE_STD, RADIAL_LIMIT

if TYPE_CHECKING:
    from fusion.calibration.depth.calibration import DepthCalibration
    from fusion.results.depth_figures import DepthFigures, LeftFigures

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
    from fusion.results.depth_figures import depth_figures
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
    figures = depth_figures(found)
    if options.json:
        print(json_text(json_values(figures) | {"output": options.output}))
    else:
        print("\n".join([*_lines(figures), *made(options, "sensor", "report")]))


def fill(folder: Path, found: "DepthCalibration", settings: Mapping[str, object] | None) -> None:
    """sensor.json with its maps, and report.html with the settings if any, into a folder."""
    from fusion.report.calibrations.depth_calibration import depth_report
    from fusion.sensor.files.sensor_file import write_sensor

    write_sensor(folder / "sensor.json", found.sensor)
    if settings is not None:
        with stage("report"):
            depth_report(folder / "report.html", found, "fusion " + " ".join(sys.argv[1:]), settings)


def _reach(limit: float | None) -> str:
    if limit is None:
        return "the border of what was recorded: no ring of the image is twice as bad as the others"
    return f"{limit:.0f} px from the principal point; beyond, the corrected depth is twice as bad (--radial-limit)"


def _left(left: "LeftFigures") -> str:
    half, near, _, far, twice = (
        f"{1e3 * std:.1f} mm at {z:.2f} m" for z, std in zip(left.distance_m, left.std_m, strict=True)
    )
    return f"{near}, {far}; beyond the walls {half}, {twice} (one standard deviation, what no wall tells counted in)"


def _lines(told: "DepthFigures") -> list[str]:
    low, high = told.heldout_before_m * 1e3, told.heldout_after_m * 1e3
    glossy = " (what the board mirrors taken out too)" if "gloss" in told.law else ""
    held_out = f"{high:.2f} mm rms on a wall left out{glossy}, {low:.2f} mm without correction"
    if not any(math.isfinite(wall.distance_m) for wall in told.walls):
        held_out += "; of its shape, as no wall's distance is known"
    return [
        f"law       {told.law}, of {len(told.candidates)} candidates",
        f"held out  {held_out if len(told.walls) > 1 else 'one wall: nothing'}",
        *([] if told.left is None else [f"left      {_left(told.left)}"]),
        f"good to   {_reach(told.radial_limit_px)}",
        *(f"note      {text}" for text in told.notes),
    ]
