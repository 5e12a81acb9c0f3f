"""`fusion compare`: signed distances between a mesh and a reference, in both directions."""

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fusion.commands.numbers import number
from fusion.commands.results import add_output, made
from fusion.progress import stage
from fusion.quantity import MAX_DISTANCE

if TYPE_CHECKING:
    from fusion.mesh.compare import Comparison

EXAMPLE = "fusion compare mesh.ply reference.stl -o out --scale"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    add("mesh", type=Path, metavar="MESH", help="the scan: PLY, OBJ, STL, GLB, OFF, PCD, XYZ, ASC or E57")
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
    add("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> None:
    """Compare and write the results."""
    from fusion.mesh.compare import CompareSettings, compare, write_comparison
    from fusion.mesh.files import read_mesh
    from fusion.mesh.seen import read_seen
    from fusion.report.comparison import Circumstances, comparison_report
    from fusion.results.comparison import judge_comparison

    notes: list[str] = []
    mesh, reference = read_mesh(options.mesh, notes), read_mesh(options.reference, notes)
    settings = CompareSettings(
        align=not options.no_align,
        scale=options.scale,
        max_distance=options.max_distance,
        seen=None if options.seen is None else read_seen(options.seen),
        unit=options.unit,
    )
    comparison = compare(mesh, reference, settings)
    notes += comparison.notes
    about = Circumstances(
        title=f"{options.mesh.name} against {options.reference.name}",
        command="fusion " + " ".join(sys.argv[1:]),
        settings={
            "align": settings.align,
            "scale": settings.scale,
            "max_distance": settings.max_distance,
            "seen": str(options.seen) if options.seen else None,
            "samples": settings.samples,
            "unit": settings.unit,
        },
        fingerprint={"mesh": str(options.mesh), "reference": str(options.reference)},
        warnings=[("warning", note) for note in notes],
    )
    with options.claim.folder() as partial:
        write_comparison(partial, comparison)
        if options.report:
            with stage("report"):
                comparison_report(partial / "report.html", comparison, comparison.mesh, comparison.reference, about)
    judgement = judge_comparison(comparison)
    if options.json:
        print(
            json.dumps(
                comparison.to_dict() | {"judgement": judgement.values()} | {"output": str(options.output)},
                indent=1,
                allow_nan=False,
            )
        )
        return
    if not options.quiet:
        sys.stderr.writelines(f"note: {note}\n" for note in notes)
    print("\n".join([*judgement.lines(), *_lines(comparison), *made(options, "report", width=14)]))


def _lines(comparison: "Comparison") -> list[str]:
    interval = comparison.scale_interval
    scale = f"scale {comparison.scale:.5f}"
    if interval:
        scale += f" (95 %: {interval[0]:.5f} to {interval[1]:.5f})"
    elif comparison.scale == 1:
        scale += " (kept)"
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


def _block(block: dict[str, Any]) -> str:
    return (
        f"{block['rms'] * 1e3:.2f} mm rms, mean {block['mean_signed'] * 1e3:+.2f} mm, "
        f"95 % below {block['p95'] * 1e3:.2f} mm, {block['within']['0.002']:.1%} within 2 mm"
    )
