"""A series of drawn cases: each is made, run, judged and printed, and the table grows in a file."""

import argparse
import json
import shutil
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

Judged = TypeVar("Judged")


@dataclass(frozen=True)
class Table(Generic[Judged]):
    """How judged cases are told: first line, a line and a row of each, and what all of them say together."""

    head: str
    line: Callable[[Judged], str]
    row: Callable[[Judged], dict[str, Any]]
    summary: Callable[[list[Judged]], str]


@dataclass(frozen=True)
class Series(Generic[Judged]):
    """What is run.

    Attributes:
        case: pattern of the folders' names, of the number.
        made: writes the case of a number into a folder.
        judged: runs the commands over a folder and measures.
        table: how it is told.
        bulky: patterns of the folders that go once a case is judged.
    """

    case: str
    made: Callable[[int, Path], None]
    judged: Callable[[Path], Judged]
    table: Table[Judged]
    bulky: Sequence[str]

    def run(self, numbers: Sequence[int], options: argparse.Namespace) -> int:
        """Make, run, judge, print."""
        cases: list[Judged] = []
        print(self.table.head, flush=True)
        for k in numbers if options.only is None else options.only:
            folder = options.output / self.case.format(k)
            if not options.made:
                begin = time.monotonic()
                self.made(k, folder)
                print(f"{folder.name}: made in {time.monotonic() - begin:.0f} s", file=sys.stderr, flush=True)
            if options.make_only:
                continue
            cases.append(self.judged(folder))
            print(self.table.line(cases[-1]), flush=True)
            self._keep(cases, folder, options)
        if cases:
            print(self.table.summary(cases))
        return 0

    def _keep(self, cases: list[Judged], folder: Path, options: argparse.Namespace) -> None:
        table, rows = self.table, [self.table.row(case) for case in cases]
        (folder / "judged.json").write_text(json.dumps(rows[-1], indent=1), encoding="utf-8")
        for bulky in () if options.keep else self.bulky:
            for path in folder.glob(bulky):
                if path.is_dir():  # what a command said stays, in a file beside its folder
                    shutil.rmtree(path)
        lines = [table.head, *map(table.line, cases), table.summary(cases), ""]
        (options.output / "table.txt").write_text("\n".join(lines), encoding="utf-8")
        (options.output / "table.json").write_text(json.dumps(rows, indent=1), encoding="utf-8")


def options_of(description: str | None, name: str, count: int) -> argparse.ArgumentParser:
    """The options of a series of so many cases, called `name`."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument(f"--{name}", type=int, default=count)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, nargs="+", metavar="K", help=f"these {name} alone")
    parser.add_argument("--keep", action="store_true", help="keep recordings and results")
    parser.add_argument("--make-only", action="store_true", help="write the recordings and stop")
    parser.add_argument("--made", action="store_true", help="the recordings are there: judge them anew")
    return parser
