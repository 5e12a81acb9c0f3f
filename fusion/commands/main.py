"""`fusion COMMAND ...`: finds the command, runs it, turns errors into one line."""

import argparse
import errno
import os
import sys
import traceback
from contextlib import ExitStack
from pathlib import Path
from types import ModuleType

from fusion import __version__
from fusion.commands.catalogue import COMMANDS, load
from fusion.commands.options.inputs import inputs
from fusion.commands.parser import CommandParser, Parser
from fusion.commands.terminal.own_lines import show_own_lines
from fusion.commands.terminal.stopping import Stop, stoppable
from fusion.compute.process import tune_process
from fusion.errors import FusionError
from fusion.files.limits import USUAL_GB
from fusion.files.trust import trust


def main(arguments: list[str] | None = None) -> int:
    """Run the program; returns the exit status: 0 success, 1 a problem with the input, 2 wrong usage, 130 Ctrl-C."""
    with stoppable() as stop:
        try:
            return _main(arguments, stop)
        except KeyboardInterrupt:  # while modules were loaded; later `_run` tells it
            sys.stderr.write(f"fusion: {stop.words}\n")
            return stop.status


def _main(arguments: list[str] | None, stop: Stop) -> int:
    # read when numpy is loaded. The many small systems here gain nothing from more threads, which spin while they wait:
    # `fusion explain` took 29 instead of 15 s of processor, and no less time
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    alone = arguments is None  # not called by another program
    if arguments is None:
        tune_process()
        arguments = sys.argv[1:]
    if not arguments:  # who asks nothing wants to know what there is: no error
        overview().print_help()
        return 0
    # all up to the command's name; its own options stay untouched for its own parser
    end = next((i + 1 for i, word in enumerate(arguments) if not word.startswith("-")), len(arguments))
    parser = overview()
    parser.add_argument("command", choices=COMMANDS, metavar="COMMAND", help=argparse.SUPPRESS)
    chosen = parser.parse_args(arguments[:end])
    try:
        command = load(chosen.command)
    except (ImportError, OSError) as error:
        sys.stderr.write(f"fusion {chosen.command}: {_refused(error, verbose=False)}\n")
        return 1
    parser = parser_of(chosen.command, command)
    try:
        options = parser.parse_args(arguments[end:])
    except FusionError as error:  # a number that is not possible: told before any work
        sys.stderr.write(f"{parser.prog}: {error}\n")
        return 1
    options.quiet, options.verbose = "quiet" in options, "verbose" in options
    if alone:
        show_own_lines(options.verbose)
    trust(options.allow_gb if "allow_gb" in options else USUAL_GB, "follow_links" in options)
    if getattr(options, "device", None):
        os.environ["FUSION_DEVICE"] = options.device
    return _run(chosen.command, command, options, stop)


def _run(name: str, command: ModuleType, options: argparse.Namespace, stop: Stop) -> int:
    """The command's exit status; what goes wrong is told in one line."""
    # not at the top: `fusion --help` needs none of them
    from fusion.commands.terminal.screen import showing
    from fusion.commands.terminal.verbose import tell_begin, tell_end
    from fusion.files.output.claim import claimed
    from fusion.files.output.staging import remove_held

    options.claim = None
    try:
        with ExitStack() as around:
            if hasattr(command, "check"):
                command.check(options)
            if getattr(options, "output", None) is not None:
                made_by = " ".join(filter(None, [name, getattr(options, "part", None)]))
                claim = claimed(options.output, made_by, inputs(options), options.overwrite, options.folder)
                options.claim = around.enter_context(claim)
            if options.verbose:
                tell_begin(options)
            with showing(options.quiet):
                status = int(command.run(options) or 0)
            sys.stdout.flush()  # what is refused only then is told like all else
        if options.verbose:
            tell_end(options)
        return status
    except BrokenPipeError:  # the reader of our output went away: not a failure of ours
        _drop_stdout()
        return 0
    except KeyboardInterrupt:
        said = ""
    except Exception as error:
        said = _said(error, options.verbose)
    if not said or stop.number:  # libraries turn an interruption into errors of their own
        remove_held()
        written = "" if options.claim is None else f"; {options.claim.outcome}"
        sys.stderr.write(f"fusion {name}: {stop.words}{written}\n")
        return stop.status
    sys.stderr.write(f"fusion {name}: {said}\n")
    return 1


def _said(error: Exception, verbose: bool) -> str:
    """What went wrong, in one line."""
    if isinstance(error, FusionError):
        return str(error)
    if isinstance(error, MemoryError):
        return "out of memory; use a larger --voxel or fewer frames"
    if isinstance(error, ImportError | OSError):
        return _refused(error, verbose)
    return _unexpected(error, verbose)


def _drop_stdout() -> None:
    """What is still to be printed goes nowhere, or Python would complain about it in the end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _refused(error: ImportError | OSError, verbose: bool) -> str:
    """What the system did not load or do."""
    from fusion.commands.terminal.failed_import import failed_import  # seldom needed

    if isinstance(error, OSError) and error.errno == errno.ENOSPC and not error.filename:  # none: it is no file
        _drop_stdout()
        return "the disk that takes what is printed is full"
    if problem := failed_import(error):
        return str(problem)
    if isinstance(error, ImportError):
        return _unexpected(error, verbose)
    return str(FusionError(error.strerror or str(error), error.filename or ""))


def _unexpected(error: Exception, verbose: bool) -> str:
    """A slip of the program itself: where, in one line; the traceback goes before it when asked for."""
    if verbose:
        traceback.print_exception(error)
    last = traceback.extract_tb(error.__traceback__)[-1]
    where = f"{Path(last.filename).name}, line {last.lineno}"
    hint = "" if verbose else "-v shows the traceback"
    what = "a fault of the program itself, please report it"
    return str(FusionError(f"{what}: {type(error).__name__}: {error}", where, do=hint))


def parser_of(name: str, command: ModuleType) -> CommandParser:
    """What reads the options of a command, and tells them."""
    parser = CommandParser(
        prog=f"fusion {name}",
        description=COMMANDS[name].capitalize() + ".",
        epilog=f"example: {command.EXAMPLE}",
    )
    command.add_arguments(parser)
    return parser


def overview() -> Parser:
    """What knows the program's own options, and lists the commands."""
    width = max(map(len, COMMANDS))
    lines = "\n".join(f"  {name:<{width}}  {text}" for name, text in COMMANDS.items())
    parser = Parser(
        prog="fusion",
        usage="fusion [-h] [--version] COMMAND ...",
        description=f"Metric 3D scanning with depth cameras.\n\ncommands:\n{lines}",
        epilog="example: fusion turntable my_scan -o out      (fusion COMMAND --help tells more)",
    )
    parser.add_argument("--version", action="version", version=f"fusion {__version__}")
    return parser
