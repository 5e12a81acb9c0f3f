"""The options of a table that the program turns, of the commands that take frames from a camera."""

import argparse
from typing import TYPE_CHECKING

from fusion.commands.options.numbers import number
from fusion.quantity import SETTLE, STEP

if TYPE_CHECKING:
    from fusion.devices.source import Source

TABLE = "grbl:PORT[:AXIS] or a command, 'my_table --to {angle}' or '... --by {step}' [deg]"


def add_table(parser: argparse.ArgumentParser) -> None:
    """Which table, and how it is turned."""
    add = parser.add_argument
    add("--table", metavar="TABLE", help=f"turn this table step by step, a frame of each place, one turn: {TABLE}")
    add("--step", type=number(STEP), metavar="DEG", help="with --table: turn between frames, its sign (default: 10)")
    add("--settle", type=number(SETTLE), metavar="S", help="with --table: wait after each step (default: 0.5 s)")


def check_table(options: argparse.Namespace) -> None:
    """Nothing is asked of a table that is none. Raises DeviceError."""
    from fusion.errors import DeviceError

    for name in ("step", "settle"):
        if getattr(options, name) is not None and options.table is None:
            raise DeviceError("there is no table to turn", f"--{name}", do="name it: --table grbl:PORT")


def watches_turn(options: argparse.Namespace) -> bool:
    """Whether the end of a turn is looked for; with a table the source itself ends, after its places."""
    return options.turn and options.table is None


def before_table(source: "Source", options: argparse.Namespace, places: int | None) -> "Source":
    """The source, of one frame a place where there is a table.

    Args:
        places: how many; None: one turn.

    Raises:
        DeviceError: the table is none, or does not answer; the source is stopped then.
    """
    if options.table is None:
        return source
    from fusion.devices.table.stepped import Stepped, open_table

    try:
        table = open_table(options.table)
    except BaseException:
        source.stop()
        raise
    given = {name: value for name in ("step", "settle") if (value := getattr(options, name)) is not None}
    return Stepped(source, table, count=places, **given)
