"""`fusion texture`: the colour images of a scan, laid on its mesh as a picture."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from fusion.commands.options.numbers import number, whole_number
from fusion.commands.options.results import add_output, add_topic
from fusion.commands.options.results import made as files_made
from fusion.commands.terminal.screen import took
from fusion.files.json_values import json_text
from fusion.progress import seconds, stage
from fusion.quantity import TEXEL, TRIANGLES

if TYPE_CHECKING:
    from fusion.texture.textured import Textured

EXAMPLE = "fusion texture out/cup -o out/cup_textured"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    add("result", type=Path, metavar="RESULT", help="folder made by fusion turntable, reconstruct or merge")
    add_output(parser, "folder for textured.glb, textured.obj with .mtl and .png, texture.json, report.html")
    add(
        "--mesh",
        type=Path,
        metavar="FILE",
        help="another mesh of it, such as one of fusion convert --watertight",
    )
    add("--triangles", type=whole_number(TRIANGLES), metavar="N", help="at most so many; default: 10000")
    add("--texel", type=number(TEXEL), metavar="M", help="edge of a texel on the object [m]; default: 2/5 of a pixel")
    add("--usdz", action="store_true", help='textured.usdz too, for phones; needs pip install "fusion-scan[usd]"')
    add("--recording", type=Path, nargs="+", metavar="REC", help="where the recordings are now, in the result's order")
    add("--camera", metavar="C", help="of the recording, if it says none: camera.json, a preset's name or fx,fy,cx,cy")
    add_topic(parser)
    add("--json", action="store_true", help="print one JSON object")


def check(options: argparse.Namespace) -> None:
    """Refuse what no work can mend."""
    if options.usdz:
        from fusion.mesh.formats.usdz import usd_library

        usd_library(options.output / "textured.usdz")


def run(options: argparse.Namespace) -> None:
    """Make the texture and write the files."""
    from fusion.texture.other_mesh import read_other
    from fusion.texture.result_folder import open_result
    from fusion.texture.textured import TRIANGLES as USUAL
    from fusion.texture.textured import texture_mesh

    scan, taken = open_result(options.result, options.recording, options.camera, options.topic)
    mesh = scan if options.mesh is None else read_other(options.mesh, scan)
    made = texture_mesh(mesh, taken, options.triangles or USUAL, options.texel, scan)
    with options.claim.folder() as partial:
        fill(partial, made, options.usdz)
        if options.report:
            _page(partial / "report.html", made, options)
    spent = seconds()
    if options.json:
        print(json_text({**made.values(), "seconds": spent, "output": options.output}))
    else:
        files = [str(options.output / "textured.glb"), *files_made(options, "report")]
        print("\n".join([*lines(made), *files, f"took      {took(spent)}"]))


def fill(folder: Path, made: "Textured", usdz: bool = False) -> None:
    """All files of the command into a folder."""
    from fusion.texture.files import write_glb, write_obj, write_usdz

    write_glb(folder / "textured.glb", made)
    write_obj(folder / "textured.obj", made)
    if usdz:
        write_usdz(folder / "textured.usdz", made)
    (folder / "texture.json").write_text(json_text(made.values()) + "\n", encoding="utf-8")


def _page(path: Path, made: "Textured", options: argparse.Namespace) -> None:
    from fusion.report.scans.texture import TextureReport, texture_report

    with stage("report"):
        settings = {
            "result": str(options.result),
            "mesh": str(options.mesh or options.result / "mesh.ply"),
            "recordings": sorted({str(source.recording.path) for source in made.views.sources}),
            "triangles_at_most": options.triangles,
            "texel_asked_m": options.texel,
        }
        told = "fusion " + " ".join(sys.argv[1:])
        texture_report(path, TextureReport(made, str(options.result), settings, told))


def lines(made: "Textured") -> list[str]:
    """The summary for a person."""
    h, w = made.image.shape[:2]
    told = made.values()
    rms, largest = (f"{1e3 * x:.2f}" for x in made.moved)
    return [
        f"mesh      {len(made.mesh.faces):,} triangles, {rms} mm rms off the scan, {largest} mm at most",
        f"texture   {w} x {h} texels of {1e3 * made.texel:.2f} mm from {made.images} images, made brighter by "
        f"{told['gain_min']:.2f} to {told['gain_max']:.2f}",
        f"light     taken out: photographs show the object {told['light_min']:.2f} to {told['light_max']:.2f} times as "
        "bright",
        f"unseen    {made.unseen_share:.1%} of the surface, in the colours around",
    ]
