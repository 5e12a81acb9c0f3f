"""`fusion convert`: between recording formats, and between mesh formats."""

import argparse
from pathlib import Path

from fusion.errors import FusionError

EXAMPLE = "fusion convert chess/seq-01 my_scan --camera 7scenes"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    parser.add_argument("input", type=Path, metavar="IN", help="folder of a recording of any format, or a mesh file")
    parser.add_argument("output", type=Path, metavar="OUT", help="new folder (native format), or a mesh file")
    parser.add_argument(
        "--camera", metavar="FILE", help="camera.json or a preset's name, instead of the recording's own"
    )
    parser.add_argument("--overwrite", action="store_true", help="replace an earlier conversion, or the mesh file OUT")


def run(options: argparse.Namespace) -> None:
    """Convert a folder to a native recording, a file to another mesh format."""
    if not options.input.exists():
        raise FusionError(
            "there is nothing to convert", options.input, "nothing", "a recording's folder or a mesh file"
        )
    if options.input.is_dir():
        _convert_recording(options)
    else:
        from fusion.mesh.files import read_mesh, write_mesh

        write_mesh(options.output, read_mesh(options.input))
    print(options.output)


def _convert_recording(options: argparse.Namespace) -> None:
    from fusion.recording.convert import convert_recording
    from fusion.recording.open import open_recording

    convert_recording(open_recording(options.input, options.camera), options.output)
