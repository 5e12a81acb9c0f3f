"""The parser of a command: what is mistyped is answered in one line, with the nearest that exists."""

import argparse
import difflib
import re
import sys
from collections.abc import Iterable
from typing import Any, NoReturn

from fusion.commands.options.numbers import number
from fusion.errors import FusionError
from fusion.files.inside import OPTION as LINKS_OPTION
from fusion.files.limits import OPTION as LIMIT_OPTION
from fusion.files.limits import USUAL_GB
from fusion.quantity import Quantity

GIGABYTES = Quantity("memory for one input", LIMIT_OPTION, "GB", 0.001, 1e6)


class Parser(argparse.ArgumentParser):
    """Wrong usage is one line and status 2; options are written out, since a new one would break what is shortened."""

    def __init__(self, **more: Any) -> None:
        super().__init__(allow_abbrev=False, formatter_class=argparse.RawDescriptionHelpFormatter, **more)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As in argparse; but an unknown option is told before anything else that is wrong, for it often is why."""
        given = sys.argv[1:] if args is None else list(args)
        known, heads = self._options(), given[: given.index("--")] if "--" in given else given
        for word in heads:
            name = word.partition("=")[0]
            if re.fullmatch(r"--\w[\w-]*", name) and name not in known:
                self.error(f"unknown option {name}{nearest(name, known)}")
        return super().parse_known_args(given, namespace)

    def _options(self) -> set[str]:
        """Every option of this parser and of those inside it."""
        found = set(self._option_string_actions)
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                for inner in action.choices.values():
                    found |= inner._options() if isinstance(inner, Parser) else set()
        return found

    def error(self, message: str) -> NoReturn:
        """One line, and status 2."""
        wrong = re.search(r"invalid choice: '(.*?)' \(choose from (.*)\)", message)
        if wrong:
            message += nearest(wrong[1], re.findall(r"[\w.-]+", wrong[2]))
        shown = FusionError(message)  # escaped, and of a readable length
        self.exit(2, f"{self.prog}: {shown}; usage: {self.prog} --help tells all\n")


class CommandParser(Parser):
    """With the options that every command has."""

    def __init__(self, **more: Any) -> None:
        super().__init__(**more)
        # without a default: a parser inside another one would overwrite what stood before its name
        add, off = self.add_argument, argparse.SUPPRESS
        add("-v", "--verbose", action="store_true", default=off, help="tell versions, settings, files, tracebacks too")
        add("-q", "--quiet", action="store_true", default=off, help="tell nothing but errors and the result")
        size = f"let one input take up to N gigabytes of memory (default: {USUAL_GB:g})"
        add(LIMIT_OPTION, type=number(GIGABYTES), default=off, metavar="N", help=size)
        trust = "read files that a recording names outside its own folder"
        add(LINKS_OPTION, action="store_true", default=off, help=trust)


def nearest(word: str, known: Iterable[str]) -> str:
    """`; did you mean that?`, or nothing when no known word is like it."""
    near = difflib.get_close_matches(word, list(known), n=1)
    return f"; did you mean {near[0]}?" if near else ""
