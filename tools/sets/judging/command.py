"""Runs the command line in a process of its own; nothing else of the program is used."""

import subprocess
import sys
import time
from dataclasses import dataclass

LIMIT = 1800  # [s] for one command
PROGRAM = "from fusion.commands.main import main; raise SystemExit(main())"


@dataclass(frozen=True)
class Ran:
    """Exit status (-1 = no end within the limit), what the terminal showed, seconds."""

    status: int
    terminal: str
    seconds: float

    @property
    def last(self) -> str:
        """Last line that is not empty: where a refusal says why."""
        lines = [line.strip() for line in self.terminal.splitlines() if line.strip()]
        return lines[-1] if lines else ""


def fusion(*arguments: object, limit: float = LIMIT) -> Ran:
    """`fusion ARGUMENTS`."""
    begin = time.monotonic()
    command = [sys.executable, "-c", PROGRAM, *map(str, arguments)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=limit)
        status, terminal = done.returncode, done.stderr + done.stdout
    except subprocess.TimeoutExpired:
        status, terminal = -1, f"no end within {limit} s"
    return Ran(status, terminal, time.monotonic() - begin)
