"""`fusion COMMAND ...`: finds the command, runs it, turns errors into one line."""

import argparse
import importlib
import os
import sys

from fusion import __version__
from fusion.commands.screen import showing
from fusion.errors import FusionError

# command: what it does, in the order of the work
COMMANDS = {
    "demo": "the whole main job on an object that the program makes itself",
    "info": "what is in a recording, and what looks wrong with it",
    "convert": "between recording formats, and between mesh formats",
    "reconstruct": "correct, track, integrate: a recording becomes a mesh",
    "turntable": "the same for an object on a turntable, with axis and closed loop",
    "simulate": "a recording as a sensor would have made it; the same seed, the same bits",
    "sensor": "a sensor model as a table with units, intervals and sources; the models known by name",
    "calibrate": "camera, depth or noise from recordings of boards and walls",
    "evaluate": "the sensor bench: noise, offset, shares, steps and drift of still recordings",
    "explain": "where simulation and recording differ, which physics is missing, and the better model",
    "compare": "signed distances between a mesh and a reference",
}


def main(arguments: list[str] | None = None) -> int:
    """Run the program; returns the exit status: 0 success, 1 a problem with the input, 2 wrong usage."""
    # read when numpy is loaded. The many small systems here gain nothing from more threads, which spin while they wait:
    # `fusion explain` took 29 instead of 15 s of processor, and no less time
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    arguments = sys.argv[1:] if arguments is None else arguments
    overview = _overview()
    # the command's own options stay untouched for its own parser
    overview.add_argument("command", choices=COMMANDS, metavar="COMMAND")
    overview.add_argument("rest", nargs=argparse.REMAINDER, help=argparse.SUPPRESS)
    chosen = overview.parse_args(arguments)
    command = importlib.import_module(f"fusion.commands.{chosen.command}")
    parser = argparse.ArgumentParser(
        prog=f"fusion {chosen.command}",
        description=COMMANDS[chosen.command].capitalize() + ".",
        epilog=f"example: {command.EXAMPLE}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.add_arguments(parser)
    parser.add_argument("-q", "--quiet", action="store_true", help="show no progress")
    options = parser.parse_args(chosen.rest)
    if getattr(options, "device", None):
        os.environ["FUSION_DEVICE"] = options.device
    try:
        with showing(options.quiet):
            return int(command.run(options) or 0)
    except FusionError as error:
        sys.stderr.write(f"fusion {chosen.command}: {error}\n")
    except MemoryError:
        sys.stderr.write(f"fusion {chosen.command}: out of memory; use a larger --voxel or fewer frames\n")
    except BrokenPipeError:  # the reader of our output went away: not a failure of ours
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        sys.stderr.write(f"fusion {chosen.command}: interrupted; nothing was written\n")
        return 130
    except OSError as error:
        where = f"; in {error.filename}" if error.filename else ""
        sys.stderr.write(f"fusion {chosen.command}: {error.strerror or error}{where}\n")
    return 1


def _overview() -> argparse.ArgumentParser:
    width = max(map(len, COMMANDS))
    lines = "\n".join(f"  {name:<{width}}  {text}" for name, text in COMMANDS.items())
    parser = argparse.ArgumentParser(
        prog="fusion",
        description=f"Metric 3D scanning with depth cameras.\n\ncommands:\n{lines}",
        epilog="example: fusion turntable my_scan -o out      (fusion COMMAND --help tells more)",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"fusion {__version__}")
    return parser
