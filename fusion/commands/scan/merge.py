"""`fusion merge`: several turntable passes of one object, turned over between them, become one mesh."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from fusion.commands.options.numbers import number
from fusion.commands.options.results import add_output, add_topic, made
from fusion.commands.terminal.screen import took
from fusion.compute.choice import DEVICES
from fusion.errors import FusionError
from fusion.files.json_values import json_text
from fusion.progress import seconds, stage
from fusion.quantity import TRUNCATION, VOXEL

if TYPE_CHECKING:
    from fusion.passes.one_pass import Pass
    from fusion.passes.result import Merged
    from fusion.passes.settings import MergeSettings

EXAMPLE = "fusion merge out/cup out/cup_turned_over -o out/cup_whole"
EACH = "; given once: for all passes, else once for each, in their order"
T = TypeVar("T")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    add(
        "passes", type=Path, nargs="+", metavar="PASS", help="result of fusion turntable, or a recording, scanned first"
    )
    add_output(parser, "folder for mesh.ply, merge.json, trajectory.txt, ...")
    add("--sensor", metavar="S", action="append", help=f"sensor.json or a preset's name{EACH}")
    add("--camera", metavar="C", action="append", help=f"camera.json, a preset's name or fx,fy,cx,cy{EACH}")
    add_topic(parser)
    add("--transforms", type=Path, metavar="FILE", help="merge.json whose transforms are used as they are, none sought")
    add("--voxel", type=number(VOXEL), metavar="M", help="edge of a voxel [m]; default: the finest of the passes")
    add("--truncation", type=number(TRUNCATION), metavar="M", help="half band around the surface [m]; default: theirs")
    add(
        "--no-color", action="store_true", help="leave the colours out, and do not ask them where shape does not decide"
    )
    add("--force", action="store_true", help="go on with a sensor model of another camera")
    add("--device", choices=DEVICES, help="where the kernels run: auto is a card if one passes; FUSION_DEVICE, or cpu")
    add("--json", action="store_true", help="print one JSON object")


def check(options: argparse.Namespace) -> None:
    """Refuse what no work can mend."""
    if len(options.passes) < 2:
        raise FusionError("a merge needs two passes or more", "PASS", len(options.passes), do="give the other pass too")
    same = [p for i, p in enumerate(options.passes) if p.resolve() in [q.resolve() for q in options.passes[:i]]]
    if same:
        raise FusionError("a pass is given twice", same[0], do="give each pass once")


def run(options: argparse.Namespace) -> None:
    """Merge and write the results."""
    from fusion.passes.pipeline import merge_passes

    settings = _settings(options)
    merged = merge_passes(_passes(options), settings)
    with options.claim.folder() as partial:
        fill(partial, merged, page=options.report)
    numbers = merged.facts.values() | merged.merge() | {"seconds": seconds()}
    if options.json:
        print(json_text(numbers | {"output": str(options.output)}))
    else:
        print("\n".join([*lines(merged), *made(options, "report"), f"took      {took(numbers['seconds'])}"]))


def _passes(options: argparse.Namespace) -> list["Pass"]:
    from fusion.passes.opened import open_pass
    from fusion.sensor.correction.unit import refuse_other_unit
    from fusion.sensor.files.sensor_file import read_sensor

    count = len(options.passes)
    sensors = _each(None if options.sensor is None else [read_sensor(s) for s in options.sensor], count, "--sensor")
    cameras = _each(options.camera, count, "--camera")
    found = []
    for path, sensor, camera in zip(options.passes, sensors, cameras, strict=True):
        found.append(open_pass(path, sensor, camera, options.topic))
        if sensor is not None:
            refuse_other_unit(sensor, found[-1].recording.camera, options.force)
    return found


def _each(given: list[T] | None, count: int, option: str) -> list[T | None]:
    """One for each pass of what was given once, or for each."""
    if given is None:
        return [None] * count
    if len(given) == 1:
        return [given[0]] * count
    if len(given) != count:
        raise FusionError("an option does not fit the passes", option, f"{len(given)} times", f"once or {count} times")
    return list(given)


def _settings(options: argparse.Namespace) -> "MergeSettings":
    from fusion.passes.settings import MergeSettings
    from fusion.passes.transforms_file import read_transforms

    return MergeSettings(
        transforms=None if options.transforms is None else read_transforms(options.transforms),
        voxel=options.voxel,
        truncation=options.truncation,
        color=not options.no_color,
    )


def fill(folder: Path, merged: "Merged", page: bool = True) -> None:
    """All files of the command into a folder; report.html if `page`."""
    from fusion.mesh.files import write_mesh
    from fusion.passes.pipeline import before
    from fusion.recording.native.trajectory_file import write_trajectory
    from fusion.report.scans.merge import MergeReport, merge_report

    def write(name: str, content: Any) -> None:
        (folder / name).write_text(json_text(content) + "\n", encoding="utf-8")

    write_mesh(folder / "mesh.ply", merged.mesh)
    for k, (one, course) in enumerate(zip(merged.passes, merged.trajectories, strict=True), 1):
        write_trajectory(folder / f"trajectory_{k}.txt", course)
        write(f"turntable_{k}.json", one.table)
    write_trajectory(folder / "trajectory.txt", merged.trajectories[0])
    write("turntable.json", merged.passes[0].table)
    write("merge.json", merged.merge())
    content = {
        "passes": [str(one.recording.path) for one in merged.passes],
        "cameras": [{k: getattr(one.recording.camera, k) for k in ("fx", "fy", "cx", "cy")} for one in merged.passes],
        "sensors": [one.sensor for one in merged.passes],
        "voxel_m": merged.volume.voxel,
        "truncation_m": merged.volume.truncation,
        "result": merged.facts.values(),
        "judgement": merged.judgement.lights,
        "warnings": merged.judgement.warnings,
        "seconds": seconds(),
    }
    write("settings.json", content)
    if page:
        with stage("report"):
            report = MergeReport(
                merged.mesh,
                [(one.name, part) for one, part in zip(merged.passes, before(merged), strict=True)],
                merged.facts,
                merged.mesh.scalars["passes_apart"],
                merged.merge(),
                merged.judgement.worth.line(),
                merged.judgement.lights,
                {name: value for name, value in content.items() if name not in ("result", "judgement", "warnings")},
                "fusion " + " ".join(sys.argv[1:]),
            )
            merge_report(folder / "report.html", report)


def lines(merged: "Merged") -> list[str]:
    """The summary for a person."""
    from fusion.results.words import mesh_words

    facts = merged.facts
    out = [f"verdict   {merged.judgement.worth.line()}", *merged.judgement.lines()]
    for one, pair in zip(merged.passes[1:], merged.pairs, strict=True):
        on = merged.passes[pair.onto].name
        out.append(
            f"pass      {one.name} on {on}: {pair.overlap:.0%} of the surface, {pair.rms * 1e3:.2f} mm rms apart"
        )
    out.append(f"frames    {facts.placed} of {facts.frames} placed")
    out.append(f"mesh      {mesh_words(facts.shape)}, voxel {merged.volume.voxel * 1e3:g} mm")
    return out
