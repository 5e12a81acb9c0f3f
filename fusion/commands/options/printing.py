"""Options of `fusion convert` that make a mesh ready to print."""

import argparse
from typing import TYPE_CHECKING

from fusion.commands.options.numbers import number, whole_number
from fusion.errors import FusionError
from fusion.quantity import SMOOTH, TRIANGLES, WALL

if TYPE_CHECKING:
    from fusion.mesh.mesh import Mesh
    from fusion.printing.ready import PrintSettings


def add_printing(parser: argparse.ArgumentParser) -> None:
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


def asked(options: argparse.Namespace) -> "PrintSettings | None":
    """What is to be done; None where nothing is."""
    if not (options.watertight or options.triangles is not None or options.smooth):
        return None
    from fusion.printing.faults import THIN
    from fusion.printing.ready import PrintSettings

    thin = THIN if options.thin is None else options.thin
    return PrintSettings(options.watertight, options.smooth, options.triangles, thin)


def check_printing(options: argparse.Namespace, recorded: bool) -> None:
    """Refuses what makes no sense before anything is read."""
    given = options.watertight or options.triangles is not None or options.smooth
    if recorded and given:
        do = "name a mesh; fusion turntable makes one of a recording"
        raise FusionError("a recording cannot be printed", options.input, "a recording", "a mesh file", do)
    if options.thin is not None and not options.watertight:
        raise FusionError("--thin is told of closed meshes", "--thin", "no --watertight", do="add --watertight")


def printable(mesh: "Mesh", settings: "PrintSettings", options: argparse.Namespace) -> "Mesh":
    """The mesh [m], z up, made ready; says what was done."""
    from fusion.errors import MeshError
    from fusion.printing.ready import print_ready

    try:
        made = print_ready(mesh, settings)
    except MeshError as error:
        raise MeshError(error.what, options.input, error.found, error.expected, error.do) from error
    print("\n".join(made.lines()))
    return made.mesh
