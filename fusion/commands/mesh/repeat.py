"""`fusion repeat`: how well several scans of one object agree."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from fusion.commands.options.numbers import number
from fusion.commands.options.results import add_keep_failed, add_output, made
from fusion.files.json_values import json_text
from fusion.progress import stage
from fusion.quantity import DIAMETER, SPACING

if TYPE_CHECKING:
    from fusion.repeatability.repeat import Repeat

EXAMPLE = "fusion repeat out/monday_* out/tuesday_* -o repeat --conditions 5 5"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    add("scans", type=Path, nargs="+", metavar="SCAN", help="meshes, or results of fusion turntable; two or more")
    add_output(parser, "folder for repeat.json, spread.ply and report.html")
    add(
        "--conditions",
        type=int,
        nargs="+",
        default=[],
        metavar="N",
        help="how many of the scans, in their order, were made under each condition (day, camera, operator)",
    )
    add(
        "--diameter", type=number(DIAMETER), metavar="M", help="of the object's spheres, as calibrated [m]: their error"
    )
    add("--spacing", type=number(SPACING), metavar="M", help="between the centres of two spheres, as calibrated [m]")
    add_keep_failed(parser, "comparison")
    add("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> None:
    """Compare the scans with each other and write the results."""
    from fusion.repeatability.repeat import RepeatSettings, repeat
    from fusion.repeatability.scans import read_scans
    from fusion.results.judgement import failure
    from fusion.results.repeat import judge_repeat, repeat_lines

    notes: list[str] = []
    scans = read_scans(options.scans, notes)
    names = tuple(scan.name for scan in scans)
    settings = RepeatSettings(tuple(options.conditions), options.diameter, options.spacing, names)
    found = repeat([scan.mesh for scan in scans], settings)
    judgement = judge_repeat(found)
    failed = failure(judgement, " ".join(map(str, options.scans)))
    if failed is not None and not options.keep_failed:
        raise failed
    content = found.to_dict() | {"judgement": judgement.lights, "notes": notes}
    with options.claim.folder() as partial:
        fill(partial, found, content, page=options.report)
    if options.json:
        print(json_text(content | {"output": str(options.output)}))
    else:
        if not options.quiet and failed is None:
            sys.stderr.writelines(f"note: {note}\n" for note in notes)
        print("\n".join([*judgement.lines(), *repeat_lines(found), *made(options, "report", width=17)]))
    if failed is not None:
        raise failed


def fill(folder: Path, found: "Repeat", content: dict[str, object], page: bool = True) -> None:
    """All files of the command into a folder; report.html if `page`."""
    from fusion.mesh.files import write_mesh
    from fusion.report.comparisons.repeat import repeat_report

    (folder / "repeat.json").write_text(json_text(content) + "\n", encoding="utf-8")
    write_mesh(folder / "spread.ply", found.mean)
    if page:
        with stage("report"):
            told: dict[str, object] = {"scans": len(found.names)}
            repeat_report(folder / "report.html", found, "fusion " + " ".join(sys.argv[1:]), told)
