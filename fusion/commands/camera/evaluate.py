"""`fusion evaluate`: what a depth camera does in front of still scenes."""

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from fusion.commands.options.numbers import number
from fusion.commands.options.results import add_output, add_topic, made
from fusion.files.json_values import json_text, json_values
from fusion.progress import stage
from fusion.quantity import DISTANCE_STD

if TYPE_CHECKING:
    from fusion.evaluation.content import EvaluationNumbers
    from fusion.evaluation.summary import Evaluation

EXAMPLE = "fusion evaluate wall_* -o bench"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    add("recordings", type=Path, nargs="+", metavar="REC", help="still frames, better 100 each; distance_m if known")
    add_output(parser, "folder for evaluation.json and report.html")
    add("--camera", metavar="C", help="camera.json, a preset's name or fx,fy,cx,cy, instead of the recordings' own")
    add_topic(parser)
    add("--sensor", metavar="S", help="sensor.json or a preset's name, to compare with")
    add("--pixel", type=int, nargs=2, metavar=("U", "V"), help="pixel whose series is shown; the centre")
    add(
        "--distance-std",
        type=number(DISTANCE_STD),
        default=0.001,
        metavar="M",
        help="standard deviation of distance_m [m]; 0.001",
    )
    add("--force", action="store_true", help="take recordings or models of another camera")
    add("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> None:
    """Evaluate and write evaluation.json and report.html."""
    from fusion.evaluation.evaluate import EvaluationSettings, evaluate
    from fusion.evaluation.numbers import numbers
    from fusion.recording.open import open_recording
    from fusion.sensor.files.sensor_file import read_sensor

    settings = EvaluationSettings(
        sensor=None if options.sensor is None else read_sensor(options.sensor),
        pixel=None if options.pixel is None else (options.pixel[0], options.pixel[1]),
        distance_std=options.distance_std,
        force=options.force,
    )
    found = evaluate([open_recording(path, options.camera, options.topic) for path in options.recordings], settings)
    result = numbers(found)
    told = {"camera": options.camera or "recordings'", "sensor": options.sensor, "distance_std_m": options.distance_std}
    with options.claim.folder() as partial:
        fill(partial, found, result, told if options.report else None)
    if options.json:
        print(json_text(json_values(result) | {"output": options.output}))
    else:
        print("\n".join([*_lines(result, found), *made(options, "report", width=8)]))


def fill(folder: Path, found: "Evaluation", result: "EvaluationNumbers", settings: Mapping[str, object] | None) -> None:
    """evaluation.json, and report.html with the settings if any, into a folder."""
    from fusion.report.evaluations.evaluation import evaluation_report

    (folder / "evaluation.json").write_text(json_text(result) + "\n", encoding="utf-8")
    if settings is not None:
        with stage("report"):
            evaluation_report(folder / "report.html", found, "fusion " + " ".join(sys.argv[1:]), settings)


def _lines(result: "EvaluationNumbers", found: "Evaluation") -> list[str]:
    return [
        result.summary,
        *(f"note    {text}" for text in result.notes),
        f"warm    {found.longest.drift.text}",
        *([] if found.ambient is None else [f"light   {found.ambient.sentence}"]),
    ]
