"""`fusion calibrate WHAT`: camera, depth or noise, each in a file of its own."""

import argparse
import importlib

EXAMPLE = "fusion calibrate depth wall_* --camera camera.json -o calibrated"

# what: its module beside this one, and what it does
PARTS = {
    "intrinsics": ("calibrate_intrinsics", "a camera from pictures of a board, IR or colour or both"),
    "depth": ("calibrate_depth", "depth correction from walls at known distances"),
    "noise": ("calibrate_noise", "noise and dropout laws from a flat target at several distances and tilts"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """One parser for each part."""
    parts = parser.add_subparsers(dest="part", required=True, metavar="WHAT")
    for name, (module, text) in PARTS.items():
        command = importlib.import_module(f"fusion.commands.camera.{module}")
        part = parts.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        part.epilog = f"example: {command.EXAMPLE}"
        command.add_arguments(part)
        part.set_defaults(run=command.run)


def run(options: argparse.Namespace) -> int | None:
    """Run the part that was asked for."""
    done: int | None = options.run(options)
    return done
