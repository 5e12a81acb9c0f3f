"""What the console program shows: its own lines only, and nothing in them that moves the cursor or hides text."""

import logging
import os
import sys
import warnings
from collections.abc import Iterable
from typing import Any, TextIO

from fusion.errors import printable


class EscapingStream:
    """A text stream that escapes what does not print; all else is that of the stream below."""

    def __init__(self, stream: TextIO, kept: str) -> None:
        self.stream, self.kept = stream, kept

    def write(self, text: str) -> int:
        """Characters taken."""
        self.stream.write(printable(text, self.kept))
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        """One after the other."""
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


def show_own_lines(verbose: bool) -> None:
    """From now on, in this process: escape what does not print and, unless `verbose`, let no library speak.

    Libraries in C write to the files 1 and 2 themselves, so these lead nowhere, and what this program prints goes out
    by other numbers. For the console program only: nobody else prints in its process.
    """
    sys.stdout = _own(sys.stdout, "\n\t", verbose)
    sys.stderr = _own(sys.stderr, "\n\t\r", verbose)  # \r: progress is drawn over itself
    if not verbose:
        if not sys.warnoptions:
            warnings.simplefilter("ignore")
        logging.getLogger().addHandler(logging.NullHandler())  # else Python prints what has no handler
    notes = logging.StreamHandler(sys.stderr)
    notes.setFormatter(logging.Formatter("note: %(message)s"))
    logging.getLogger("fusion").addHandler(notes)


def _own(stream: Any, kept: str, verbose: bool) -> Any:
    if stream is None or isinstance(stream, EscapingStream):  # closed by who called us; or done already
        return stream
    if not verbose:
        try:
            number = stream.fileno()
        except (OSError, ValueError):  # caught by another program in the same process
            return EscapingStream(stream, kept)
        stream.flush()
        kept_open = os.dup(number)
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, number)
        os.close(nowhere)
        stream = os.fdopen(kept_open, "w", encoding=stream.encoding, errors=stream.errors, buffering=1)
    stream.reconfigure(errors="backslashreplace")  # names that the terminal's encoding does not hold
    return EscapingStream(stream, kept)
