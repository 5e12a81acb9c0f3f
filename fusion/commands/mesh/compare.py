"""`fusion compare`: signed distances between a mesh and a reference, in both directions."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from fusion.commands.options.numbers import number
from fusion.commands.options.results import add_keep_failed, add_output, made
from fusion.errors import FusionError
from fusion.files.json_values import json_text
from fusion.progress import stage
from fusion.quantity import MAX_DISTANCE

if TYPE_CHECKING:
    from fusion.mesh.comparison.compare import Comparison
    from fusion.mesh.comparison.statistics import DistanceStatistics
    from fusion.repeatability.repeat import Repeat
    from fusion.results.light import Light

EXAMPLE = "fusion compare mesh.ply reference.stl -o out --scale"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    add(
        "mesh",
        type=Path,
        nargs="+",
        metavar="MESH",
        help="the scan: PLY, OBJ, STL, GLB, OFF, PCD, XYZ, ASC or E57; several scans of one object (or results of "
        "fusion turntable): their mean against the reference is the bias, what they differ by the spread",
    )
    add(
        "reference",
        type=Path,
        metavar="REFERENCE",
        help="what it should be: mesh or point cloud",
    )
    add_output(parser, "folder for comparison.json, distance.ply and report.html")
    add("--scale", action="store_true", help="find one scale as well (0.8 to 1.25)")
    add(
        "--max-distance",
        type=number(MAX_DISTANCE),
        metavar="M",
        help="leave the mesh further away than this [m] out of the accuracy",
    )
    add("--no-align", action="store_true", help="both stand in one frame already")
    add(
        "--seen",
        type=Path,
        metavar="POINTS",
        help="reference points that were seen (npz, ply): completeness over these",
    )
    add(
        "--unit",
        choices=("m", "cm", "mm", "inch"),
        help="of the reference; else it is told from the sizes of both, where these are clear",
    )
    add_keep_failed(parser, "comparison")
    add("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> None:
    """Compare and write the results."""
    from fusion.mesh.comparison.compare import CompareSettings, compare, write_comparison
    from fusion.mesh.comparison.seen import read_seen
    from fusion.mesh.files import read_mesh
    from fusion.repeatability.bias import bias_and_spread
    from fusion.report.comparisons.comparison import Circumstances, comparison_report
    from fusion.results.comparison import judge_comparison
    from fusion.results.judgement import Judgement, failure
    from fusion.results.light import worst_first

    notes: list[str] = []
    repeated = _repeated(options, notes)
    mesh = read_mesh(options.mesh[0], notes) if repeated is None else repeated.mean
    reference = read_mesh(options.reference, notes)
    settings = CompareSettings(
        align=not options.no_align,
        scale=options.scale,
        max_distance=options.max_distance,
        seen=None if options.seen is None else read_seen(options.seen),
        unit=options.unit,
    )
    comparison = compare(mesh, reference, settings)
    judgement = judge_comparison(comparison)
    unlike = [] if repeated is None or judgement.worth.word == "failed" else _unlike(repeated)
    judgement = Judgement(worst_first([*judgement.lights, *unlike]))
    failed = failure(judgement, " ".join(map(str, options.mesh)))
    if failed is not None and not options.keep_failed:
        raise failed
    notes += comparison.notes
    about = Circumstances(
        title=f"{_name(options.mesh)} against {options.reference.name}",
        command="fusion " + " ".join(sys.argv[1:]),
        settings={
            "align": settings.align,
            "scale": settings.scale,
            "max_distance": settings.max_distance,
            "seen": str(options.seen) if options.seen else None,
            "samples": settings.samples,
            "unit": settings.unit,
        },
        fingerprint={"mesh": " ".join(map(str, options.mesh)), "reference": str(options.reference)},
        warnings=[*((one.level, f"{one.reason} {one.do}") for one in unlike), *(("warning", note) for note in notes)],
    )
    apart = None if repeated is None else bias_and_spread(comparison.accuracy.rms, repeated)
    more = {} if apart is None or repeated is None else {"repeat": apart.values(), "scans": repeated.offsets()}
    with options.claim.folder() as partial:
        write_comparison(partial, comparison, more | {"judgement": judgement.lights})
        if options.report:
            with stage("report"):
                comparison_report(partial / "report.html", comparison, comparison.mesh, comparison.reference, about)
    if options.json:
        print(json_text(comparison.to_dict() | more | {"judgement": judgement.lights, "output": str(options.output)}))
    else:
        if not options.quiet and failed is None:
            sys.stderr.writelines(f"note: {note}\n" for note in notes)
        said = [] if apart is None else [f"bias, spread  {apart.words()}"]
        print("\n".join([*judgement.lines(), *_lines(comparison), *said, *made(options, "report", width=14)]))
    if failed is not None:
        raise failed


def _name(meshes: list[Path]) -> str:
    return meshes[0].name if len(meshes) == 1 else f"the mean of {len(meshes)} scans"


def _repeated(options: argparse.Namespace, notes: list[str]) -> "Repeat | None":
    """Several scans beside each other; None where there is one."""
    from fusion.repeatability.repeat import RepeatSettings, repeat
    from fusion.repeatability.scans import read_scans
    from fusion.results.repeat import judge_repeat

    if len(options.mesh) == 1:
        return None
    if options.no_align:
        do = "leave it out: several scans are laid on each other first"
        raise FusionError("--no-align is for one mesh", "--no-align", f"{len(options.mesh)} scans", do=do)
    scans = read_scans(options.mesh, notes)
    found = repeat([scan.mesh for scan in scans], RepeatSettings(names=tuple(scan.name for scan in scans)))
    worth = judge_repeat(found).worth
    if worth.word == "failed":
        raise FusionError("the scans have no mean", "MESH", worth.reasons[0].reason.rstrip("."), "scans of one object")
    return found


def _unlike(repeated: "Repeat") -> list["Light"]:
    """Which scan is off the others, as `fusion repeat` says it; nothing where they are alike."""
    from fusion.results.repeat import judge_repeat

    return [light for light in judge_repeat(repeated).lights if light.subject == "Scans alike" and light.level != "ok"]


def _lines(comparison: "Comparison") -> list[str]:
    interval = comparison.scale_interval
    scale = f"scale {comparison.scale:.5f}"
    if interval and interval[1] < float("inf"):
        scale += f" (95 %: {interval[0]:.5f} to {interval[1]:.5f})"
    else:
        scale += " (kept)" if comparison.scale == 1 else " (the end of what is looked for)"
    share = f"{comparison.alignment.inlier_share:.0%} of the mesh had a say"
    scores = ", ".join(f"{float(k) * 1e3:g} mm {v:.3f}" for k, v in comparison.fscore.items())
    known = comparison.knowable
    doubt = [] if known is None else [
        f"beyond doubt  {known.beyond_3_sigma:.1%} of the vertices beyond 3 sigma, {known.within_90:.1%} within 1.645 "
        f"sigma (sigma {1e3 * known.sigma_median:.2f} mm, median)"
    ]  # fmt: skip
    return [
        f"alignment     {comparison.alignment.status}, {share}, {scale}",
        f"accuracy      {_block(comparison.accuracy)}",
        f"completeness  {_block(comparison.completeness)}",
        f"F-score       {scores}",
        *doubt,
    ]


def _block(block: "DistanceStatistics") -> str:
    return (
        f"{block.rms * 1e3:.2f} mm rms, mean {block.mean_signed * 1e3:+.2f} mm, "
        f"95 % below {block.p95 * 1e3:.2f} mm, {block.within['0.002']:.1%} within 2 mm"
    )
