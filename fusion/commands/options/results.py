"""Options of commands that write results, and the lines that say in the end where."""

import argparse
from pathlib import Path

FILES = {"verdict": "verdict.json", "sensor": "sensor.json", "report": "report.html"}


def add_output(parser: argparse.ArgumentParser, what: str, report: bool = True, default: str | None = None) -> None:
    """`-o`, `--overwrite` and, for a command that writes a page, `--no-report`.

    Args:
        what: is written there, for the help.
        report: the command writes report.html.
        default: the folder where none is given; None makes `-o` required.
    """
    add = parser.add_argument
    if default is None:
        add("-o", "--output", type=Path, required=True, metavar="OUT", help=what)
    else:
        add("-o", "--output", type=Path, default=Path(default), metavar="OUT", help=what)
    add("--overwrite", action="store_true", help="replace an earlier result of this command in OUT")
    if report:
        add("--no-report", dest="report", action="store_false", help="write no report.html")
    parser.set_defaults(folder=True)


def add_keep_failed(parser: argparse.ArgumentParser, what: str) -> None:
    """`--keep-failed`, for a command that hands out no result of a failed `what`."""
    parser.add_argument("--keep-failed", action="store_true", help=f"write what a failed {what} found, as evidence")


def add_topic(parser: argparse.ArgumentParser) -> None:
    """`--topic`, for a command that opens recordings."""
    parser.add_argument("--topic", metavar="NAME", help="which depth stream of a bag that has several")


def made(options: argparse.Namespace, *names: str, width: int = 10) -> list[str]:
    """`report    OUT/report.html`, and so on, without a report that nobody wants."""
    wanted = [name for name in names if name != "report" or options.report]
    return [f"{name:<{width}}{options.output / FILES[name]}" for name in wanted]
