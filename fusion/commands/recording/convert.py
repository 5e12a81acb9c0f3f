"""`fusion convert`: between recording formats, and between mesh formats."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from fusion.commands.options.numbers import number, whole_number
from fusion.commands.options.posed import add_pose_convention, stated_poses
from fusion.commands.options.results import add_topic
from fusion.errors import FusionError
from fusion.quantity import SMOOTH, TRIANGLES, WALL

if TYPE_CHECKING:
    from fusion.mesh.mesh import Mesh
    from fusion.printing.ready import PrintSettings

RECORDINGS = ("native", "tum", "open3d", "nerfstudio", "mcap")
EXAMPLE = "fusion convert out/cup/mesh.ply cup.stl --watertight --triangles 100000"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    parser.add_argument(
        "input", type=Path, metavar="IN", help="recording of any format (folder or file), or a mesh file"
    )
    parser.add_argument("output", type=Path, metavar="OUT", help="new folder or file")
    parser.add_argument(
        "--format",
        choices=RECORDINGS,
        default=RECORDINGS[0],
        help="of OUT; tum, open3d: folders as these have; nerfstudio: one for splats; mcap: one file for ROS 2 "
        "(default: native)",
    )
    parser.add_argument(
        "--poses", type=Path, metavar="FILE", help="TUM trajectory instead of the recording's own poses"
    )
    add_pose_convention(parser)
    parser.add_argument(
        "--camera", metavar="FILE", help="camera.json, a preset's name or fx,fy,cx,cy, instead of the recording's own"
    )
    parser.add_argument(
        "--unit", choices=("m", "cm", "mm", "inch"), help="of the STL file, IN or OUT, which says none (default: mm)"
    )
    _add_printing(parser)
    add_topic(parser)
    parser.add_argument("--overwrite", action="store_true", help="replace an earlier conversion, or the mesh file OUT")


def check(options: argparse.Namespace) -> None:
    """What OUT cannot be, before anything is read: a recording becomes a folder or an MCAP file, a mesh a file."""
    from fusion.files.output.publish import place_of
    from fusion.mesh.files import FORMATS, WRITTEN, check_written
    from fusion.recording.formats.not_read import refusal
    from fusion.recording.open import recognised

    if not options.input.exists():
        raise FusionError("there is nothing to convert", options.input, "nothing", "a recording or a mesh file")
    # content before name: a mesh's ending tells nothing where a recording is recognised
    options.recorded = options.input.is_dir() or recognised(options.input) is not None
    options.folder = options.recorded and options.format != "mcap"
    if not options.recorded and options.input.suffix.lower() not in FORMATS:
        expected = "a recording, or a mesh file " + " ".join(FORMATS)
        raise refusal(options.input) or FusionError(
            "this is neither a recording nor a mesh", options.input, "a file", expected
        )
    made = place_of(options.output)
    if not options.recorded and made.suffix.lower() != options.output.suffix.lower():
        do = "remove the link, or name the file itself"
        raise FusionError("the output is a link to a name of another ending", options.output, made.name, do=do)
    if not options.recorded and (options.poses or options.pose_convention or options.format != RECORDINGS[0]):
        raise FusionError(
            "--format, --poses and --pose-convention are for recordings", options.input, "a mesh file", "a recording"
        )
    endings = [path.suffix.lower() for path in (options.input, options.output)]
    if options.unit is not None and (options.recorded or endings.count(".stl") != 1):
        found, expected = " to ".join(endings), "a mesh to or from .stl; others are metres"
        raise FusionError("--unit is for an STL file", options.input, found, expected, "leave it out")
    _check_printing(options, options.recorded)
    if not options.recorded:
        check_written(options.output)
    elif options.output.suffix.lower() in (*FORMATS, *WRITTEN) and not options.output.is_dir():
        do = "name a folder; fusion reconstruct and fusion turntable make a mesh of a recording"
        raise FusionError("a recording becomes no mesh file", options.output, "a mesh's name", "a folder's name", do)


def run(options: argparse.Namespace) -> None:
    """Convert a recording to one of another format, a mesh to another mesh format."""
    if options.recorded:
        from fusion.recording.formats.bags.write import write_mcap
        from fusion.recording.open import open_recording
        from fusion.recording.writing.convert import fill_conversion
        from fusion.recording.writing.folders import fill_open3d, fill_tum
        from fusion.recording.writing.nerfstudio import fill_nerfstudio

        recording = open_recording(options.input, options.camera, options.topic)
        if (poses := stated_poses(options.poses, options.pose_convention, recording)) is not None:
            recording = replace(recording, poses=poses)
        if options.format == "mcap":
            with options.claim.file() as partial:
                write_mcap(partial, recording)
            print(options.output)
            return
        others = {"tum": fill_tum, "open3d": fill_open3d, "nerfstudio": fill_nerfstudio}
        with options.claim.folder() as partial:
            others.get(options.format, fill_conversion)(partial, recording)
    else:
        from fusion.mesh.files import read_mesh, write_mesh
        from fusion.mesh.formats.conventions import STL_UNIT, for_file, from_file

        source, target = options.input.suffix.lower(), options.output.suffix.lower()
        unit = options.unit or STL_UNIT
        mesh = read_mesh(options.input)
        wanted = _print_settings(options)
        if source != target or wanted is not None:
            mesh = from_file(mesh, source, unit)
            mesh = mesh if wanted is None else _printable(mesh, wanted, options)
            mesh = for_file(mesh, target, unit)
        with options.claim.file() as partial:
            write_mesh(partial, mesh)
        # a wrong unit shows itself by it
        size = " x ".join(f"{length:.4g}" for length in mesh.vertices.max(axis=0) - mesh.vertices.min(axis=0))
        print(f"size: {size} {unit if target == '.stl' else 'm'}")
    print(options.output)


def _add_printing(parser: argparse.ArgumentParser) -> None:
    """The options, in a group of their own."""
    add = parser.add_argument_group("for meshes, to print").add_argument
    add(
        "--watertight",
        action="store_true",
        help="close all holes, stand it on z = 0, check that it is a solid; what was closed is marked (scalar closed)",
    )
    add("--triangles", type=whole_number(TRIANGLES), metavar="N", help="at most so many; says how far that moves it")
    add("--smooth", type=whole_number(SMOOTH), default=0, metavar="N", help="steps of smoothing; 5 takes noise out")
    add("--thin", type=number(WALL), metavar="M", help="with --watertight: tell walls thinner than this [m]; 0.0008")


def _print_settings(options: argparse.Namespace) -> "PrintSettings | None":
    """What is to be done; None where nothing is."""
    if not (options.watertight or options.triangles is not None or options.smooth):
        return None
    from fusion.printing.faults import THIN
    from fusion.printing.ready import PrintSettings

    thin = THIN if options.thin is None else options.thin
    return PrintSettings(options.watertight, options.smooth, options.triangles, thin)


def _check_printing(options: argparse.Namespace, recorded: bool) -> None:
    """Refuses what makes no sense before anything is read."""
    given = options.watertight or options.triangles is not None or options.smooth
    if recorded and given:
        do = "name a mesh; fusion turntable makes one of a recording"
        raise FusionError("a recording cannot be printed", options.input, "a recording", "a mesh file", do)
    if options.thin is not None and not options.watertight:
        raise FusionError("--thin is told of closed meshes", "--thin", "no --watertight", do="add --watertight")


def _printable(mesh: "Mesh", settings: "PrintSettings", options: argparse.Namespace) -> "Mesh":
    """The mesh [m], z up, made ready; says what was done."""
    from fusion.errors import MeshError
    from fusion.printing.ready import print_ready

    try:
        made = print_ready(mesh, settings)
    except MeshError as error:
        raise MeshError(error.what, options.input, error.found, error.expected, error.do) from error
    print("\n".join(made.lines()))
    return made.mesh
