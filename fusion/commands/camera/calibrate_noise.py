"""`fusion calibrate noise`: a flat target at several distances and tilts becomes noise and dropout laws."""

import argparse
import math
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from fusion.commands.options.results import add_output, add_topic, made
from fusion.files.json_values import json_text, json_values
from fusion.progress import stage

if TYPE_CHECKING:
    from fusion.calibration.noise.calibration import NoiseCalibration
    from fusion.results.noise_figures import LawFigures, NoiseFigures

EXAMPLE = "fusion calibrate noise target_* --sensor calibrated/sensor.json -o noise"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    add("recordings", type=Path, nargs="+", metavar="REC", help="a still target each, or one after the other in one")
    add_output(parser, "folder for sensor.json and report.html")
    add("--camera", metavar="C", help="calibrated camera.json, a preset's name or fx,fy,cx,cy")
    add_topic(parser)
    add("--sensor", metavar="S", help="sensor.json or a preset's name: what is already known, depth errors above all")
    add("--force", action="store_true", help="take recordings or models of another camera")
    add("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> None:
    """Calibrate and write sensor.json and report.html."""
    from fusion.calibration.noise.calibration import NoiseSettings, calibrate_noise
    from fusion.recording.open import open_recording, stated_camera
    from fusion.results.noise_figures import noise_figures
    from fusion.sensor.files.sensor_file import read_sensor

    settings = NoiseSettings(
        camera=stated_camera(options.camera, options.recordings[0], options.topic),
        sensor=None if options.sensor is None else read_sensor(options.sensor),
        force=options.force,
    )
    found = calibrate_noise([open_recording(path, topic=options.topic) for path in options.recordings], settings)
    told = {"camera": options.camera or "recordings'", "sensor": options.sensor or "none"}
    with options.claim.folder() as partial:
        fill(partial, found, told if options.report else None)
    figures = noise_figures(found)
    if options.json:
        print(json_text(json_values(figures) | {"output": options.output}))
    else:
        print("\n".join([*_lines(figures), *made(options, "sensor", "report")]))


def fill(folder: Path, found: "NoiseCalibration", settings: Mapping[str, object] | None) -> None:
    """sensor.json with its maps, and report.html with the settings if any, into a folder."""
    from fusion.report.calibrations.noise_calibration import noise_report
    from fusion.sensor.files.sensor_file import write_sensor

    write_sensor(folder / "sensor.json", found.sensor)
    if settings is not None:
        with stage("report"):
            noise_report(folder / "report.html", found, "fusion " + " ".join(sys.argv[1:]), settings)


def _lines(told: "NoiseFigures") -> list[str]:
    axial, lateral = told.axial, told.lateral
    lines = [f"axial     {axial.law}, of {len(axial.candidates)}; {axial.rms * 1e3:.3f} mm rms left over"]
    lines += _rows(axial)
    if lateral is not None:
        lines += [f"lateral   {lateral.law}", *_rows(lateral)]
        for metres, text in (
            (lateral.percentile_90_m, "90 % of the edges below"),
            (lateral.percentile_90_shadow_m, "beside a shadow"),
        ):
            lines += [f"  {text} {metres * 1e3:.2f} mm"] if math.isfinite(metres) else []
    return [*lines, *(f"note      {text}" for text in told.notes)]


def _rows(law: "LawFigures") -> list[str]:
    return [f"  {name:<15} {number}" for name, number in law.parameters.items()]
